//! Lists the files of the folders `props` and `bodies`; of props a constant for each, so that code names none that is not
//! there.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn toml_files(folder: &Path, found: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            toml_files(&path, found)?;
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            found.push(path);
        }
    }
    Ok(())
}

/// The files of a folder, by name, with each one's name without its ending.
fn named_files(root: &Path, folder: &str) -> Result<Vec<(String, PathBuf)>, Box<dyn Error>> {
    println!("cargo::rerun-if-changed={folder}");
    let mut files = Vec::new();
    toml_files(&root.join(folder), &mut files)?;
    files.sort_by_key(|path| path.file_name().map(ToOwned::to_owned));
    let named = |path: PathBuf| {
        let name = path.file_stem().and_then(|stem| stem.to_str()).ok_or("a file's name is no text")?.to_owned();
        Ok((name, path))
    };
    files.into_iter().map(named).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let (mut list, mut constants, mut materials) = (String::new(), String::new(), String::new());
    let mut count = 0;
    for (name, path) in named_files(&root, "props")? {
        if name == "materials" {
            writeln!(materials, "const MATERIALS: &str = include_str!({path:?});")?;
            continue;
        }
        let file = path.strip_prefix(&root)?;
        writeln!(list, "    ({name:?}, {file:?}, include_str!({path:?})),")?;
        writeln!(constants, "/// `{}`.", file.display())?;
        writeln!(constants, "pub const {}: Shipped = Shipped({count});", name.to_uppercase().replace('-', "_"))?;
        count += 1;
    }
    let code = format!("pub(super) const FILES: [(&str, &str, &str); {count}] = [\n{list}];\n{constants}{materials}");
    fs::write(out.join("shipped_props.rs"), code)?;

    let mut bodies = String::new();
    for (_, path) in named_files(&root, "bodies")? {
        writeln!(bodies, "    ({:?}, include_str!({path:?})),", path.strip_prefix(&root)?)?;
    }
    fs::write(out.join("bodies.rs"), format!("const FILES: &[(&str, &str)] = &[\n{bodies}];\n"))?;
    Ok(())
}
