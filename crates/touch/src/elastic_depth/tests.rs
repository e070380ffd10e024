//! Tests of the inverse.
