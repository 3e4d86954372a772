//! Camera files and flags as the program opens and reads them.

mod files;
mod flags;
