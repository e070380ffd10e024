//! The files of the page; they are part of the program.

/// A file of the page.
#[derive(Debug)]
pub(crate) struct Asset {
    pub(crate) path: &'static str,
    pub(crate) media_type: &'static str,
    pub(crate) bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

macro_rules! asset {
    ($name:literal, $media_type:expr) => {
        Asset {
            path: concat!("/", $name),
            media_type: $media_type,
            bytes: include_bytes!(concat!("../assets/", $name)),
        }
    };
}

/// All files.
pub(crate) const ASSETS: [Asset; 14] = [
    asset!("index.html", HTML),
    asset!("style.css", STYLE),
    asset!("app.js", SCRIPT),
    asset!("arrows.js", SCRIPT),
    asset!("charts.js", SCRIPT),
    asset!("colours.js", SCRIPT),
    asset!("connection.js", SCRIPT),
    asset!("health.js", SCRIPT),
    asset!("pictures.js", SCRIPT),
    asset!("sensor.js", SCRIPT),
    asset!("surface.js", SCRIPT),
    asset!("wire.js", SCRIPT),
    asset!("uPlot.iife.min.js", SCRIPT),
    asset!("uPlot.min.css", STYLE),
];

/// The file at a path; the page itself at `/`.
pub(crate) fn asset(path: &str) -> Option<&'static Asset> {
    let path = if path == "/" { "/index.html" } else { path };
    ASSETS.iter().find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest sum of the files, bytes, so that the page opens quickly even over a slow network.
    const MOST_BYTES: usize = 300_000;

    #[test]
    fn the_page_is_light() {
        let bytes: usize = ASSETS.iter().map(|asset| asset.bytes.len()).sum();
        assert!(bytes <= MOST_BYTES, "{bytes} bytes");
    }

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        for asset in ASSETS.iter().filter(|asset| !asset.path.contains("uPlot")) {
            let text = std::str::from_utf8(asset.bytes).unwrap();
            for word in text.split(['"', '\'', '`', '(', ' ']) {
                let is_remote =
                    word.starts_with("http://") || word.starts_with("https://") || word.starts_with("//cdn");
                assert!(!is_remote || word.starts_with("http://www.w3.org/"), "{}: {word}", asset.path);
            }
        }
    }

    #[test]
    fn every_file_that_the_page_names_is_there() {
        for asset in ASSETS.iter().filter(|asset| !asset.path.contains("uPlot")) {
            let text = std::str::from_utf8(asset.bytes).unwrap();
            let named = text.split(['"', '\'']).filter(|word| word.starts_with("./") || word.starts_with("/u"));
            for name in named {
                let path = name.trim_start_matches('.');
                assert!(super::asset(path).is_some(), "{} names {name}", asset.path);
            }
        }
    }
}
