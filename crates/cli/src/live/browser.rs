//! The user's browser.

/// Opens an address in the browser; false if there is none, as on a machine without a screen.
pub(super) fn open(url: &str) -> bool {
    has_screen() && open::that_detached(url).is_ok()
}

fn has_screen() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(any(target_os = "linux", target_os = "freebsd")) || is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")
}
