use fingervision_elastic::LayerError;

/// Why the elastic inverse cannot be made for a gel and a camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ElasticError {
    /// The camera does not see the gel.
    #[error("depth: no pixel of the region of interest shows the undeformed gel")]
    NoSurface,
    /// The gel's elastic model cannot be made.
    #[error("gel: {0}")]
    Gel(#[from] LayerError),
}
