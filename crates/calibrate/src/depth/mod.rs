//! The line from the density feature to depth, from presses of known depth.
