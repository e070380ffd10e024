//! The camera, from a patterned board that slides in known steps.
