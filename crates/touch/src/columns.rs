//! The names of a reading's numbers in tables: those of a run, of a simulated press and of a calibration.

/// A frame's number in the recording.
pub const SEQUENCE_COLUMN: &str = "sequence";
/// A frame's number where every frame has a row, from 0.
pub const FRAME_COLUMN: &str = "frame";
/// The known depth of a press, mm.
pub const DEPTH_COLUMN: &str = "depth_mm";
/// The largest depth of a reading, mm.
pub const MAX_DEPTH_COLUMN: &str = "max_depth_mm";
/// The area of contact, mm².
pub const CONTACT_AREA_COLUMN: &str = "contact_area_mm2";
/// The force on the gel, `(x, y, z)`, N.
pub const FORCE_COLUMNS: [&str; 3] = ["force_x_n", "force_y_n", "force_z_n"];
/// The torque on the gel about z, N mm.
pub const TORQUE_COLUMN: &str = "torque_z_nmm";
