//! What the page asks for.

use std::path::PathBuf;

use fingervision_page::Actions;

/// Actions of a live command.
#[derive(Debug)]
pub(super) struct LiveActions;

impl Actions for LiveActions {
    fn set_recording(&self, _: bool) -> Result<Option<PathBuf>, String> {
        Err("recording is not possible yet".into())
    }

    fn recording(&self) -> Option<(PathBuf, u64)> {
        None
    }
}
