//! Shell completions and manual pages: both are made from the same description as the help.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::CommandFactory;
use clap_complete::Shell;
use clap_mangen::Man;
use fingervision_sink::write_file;

use crate::Cli;
use crate::failure::Failure;

/// The command's name, and that of its first page.
const NAME: &str = "fingervision";

/// Print the completions of a shell, which completes commands and options with Tab
///
/// In bash for this session: source <(fingervision completions bash). For all sessions, write them where the shell looks
/// for them, as in fingervision completions bash > ~/.local/share/bash-completion/completions/fingervision
#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Write the manual: a page for the command and one for each subcommand
///
/// Without --out the first page is printed, to be read with: fingervision man | man -l -
#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// The folder to write all pages to, as in ~/.local/share/man/man1; earlier pages there are replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub(crate) fn completions(args: &CompletionsArgs, out: &mut impl Write) -> Result<(), Failure> {
    // A closed pipe is not an error: the page is generated first and then written here.
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), NAME, &mut text);
    Ok(out.write_all(&text)?)
}

pub(crate) fn man(args: &ManArgs, out: &mut impl Write) -> Result<(), Failure> {
    // `help` has no page of its own.
    let mut command = Cli::command().disable_help_subcommand(true);
    let Some(folder) = &args.out else { return Ok(out.write_all(&text(&Man::new(command))?)?) };
    fs::create_dir_all(folder).map_err(|error| {
        let message = format!("{}: the pages cannot be written: {}", folder.display(), error.kind());
        Failure::new(message, "name a writable folder with --out")
    })?;
    command.build();
    write_pages(&command, folder)?;
    let folder = folder.display();
    writeln!(out, "the manual is in {folder}; read it with: man -l {folder}/{NAME}.1")?;
    Ok(())
}

/// Writes the page of a command and those of its subcommands.
fn write_pages(command: &clap::Command, folder: &Path) -> Result<(), Failure> {
    for subcommand in command.get_subcommands().filter(|subcommand| !subcommand.is_hide_set()) {
        write_pages(subcommand, folder)?;
    }
    let page = Man::new(command.clone());
    Ok(write_file(&folder.join(page.get_filename()), &text(&page)?)?)
}

fn text(page: &Man) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    page.render(&mut text)?;
    Ok(text)
}
