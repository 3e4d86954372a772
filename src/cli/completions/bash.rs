//! Completion in bash, which splits words at `=` and `:` where the program does not.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;

use clap_complete::engine::complete;
use clap_complete::env::EnvCompleter;

/// Joins the words as the program will see them, asks it, and takes off again what bash regards as
/// words of their own.
const SCRIPT: &str = r#"
_FUNCTION() {
    local IFS=$'\n' line=$COMP_LINE words=() piece cut= i path
    line=${line#*"${COMP_WORDS[0]}"}
    words=("${COMP_WORDS[0]}")
    for ((i = 1; i <= COMP_CWORD; i++)); do
        piece=${COMP_WORDS[i]}
        if ((i == COMP_CWORD)) && [[ $piece != [=:] ]]; then piece=$2; fi
        path=${line#"${line%%[![:space:]]*}"}
        if [[ -n $line && $path == "$line" ]]; then
            cut=${words[-1]}
            [[ $piece == [=:] ]] && cut+=$piece
            words[-1]+=$piece
        else
            cut=
            words+=("$piece")
        fi
        line=${path#"${COMP_WORDS[i]}"}
    done
    local program=${words[0]/#\~\//$HOME/}
    COMPREPLY=($(VARIABLE=bash "$program" -- "${words[@]}" 2>/dev/null))
    for i in "${!COMPREPLY[@]}"; do
        COMPREPLY[i]=${COMPREPLY[i]#"$cut"}
        path=${COMPREPLY[i]/#\~\//$HOME/}
        if [[ -e $path ]]; then
            compopt -o filenames 2>/dev/null
            [[ -d $path ]] && COMPREPLY[i]=${COMPREPLY[i]%/}
        fi
    done
    if ((${#COMPREPLY[@]} == 1)) && [[ ${COMPREPLY[0]} == *[=:/] ]]; then
        compopt -o nospace 2>/dev/null
    fi
}
complete -o bashdefault -o default -o nosort -F _FUNCTION NAME
"#;

/// The adapter.
#[derive(Debug)]
pub struct Bash;

impl EnvCompleter for Bash {
    fn name(&self) -> &'static str {
        "bash"
    }

    fn is(&self, name: &str) -> bool {
        name == "bash"
    }

    fn write_registration(
        &self,
        variable: &str,
        name: &str,
        program: &str,
        _completer: &str,
        script: &mut dyn Write,
    ) -> io::Result<()> {
        let function = format!("complete_{}", name.replace('-', "_"));
        let text = SCRIPT.replace("FUNCTION", &function);
        let text = text.replace("VARIABLE", variable).replace("NAME", program);
        script.write_all(text.trim_start().as_bytes())
    }

    /// The words end with the one under the cursor.
    fn write_complete(
        &self,
        command: &mut clap::Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let last = words.len() - 1;
        let wants_flags = words[last].to_string_lossy().starts_with('-');
        let found = complete(command, words, last, folder)?;
        let (flags, others): (Vec<_>, Vec<_>) =
            found.iter().partition(|c| c.get_value().to_string_lossy().starts_with('-'));
        // Flags are offered where one has been begun, or where nothing else can stand.
        let offered = if wants_flags || others.is_empty() { flags } else { others };
        for candidate in offered {
            writeln!(out, "{}", candidate.get_value().to_string_lossy())?;
        }
        Ok(())
    }
}
