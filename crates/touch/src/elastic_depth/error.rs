use fingervision_elastic::LayerError;

/// Why there is no elastic inverse for a gel and a camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElasticError {
    /// The camera does not see the gel.
    #[error("depth: the camera sees the undeformed gel in no pixel of the region")]
    NoSurface,
    /// The gel's elastic model cannot be made.
    #[error("gel: {0}")]
    Gel(#[from] LayerError),
}
