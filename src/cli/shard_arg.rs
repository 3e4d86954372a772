//! One part of many, as it is typed.

use std::str::FromStr;

use powergs_study::sweep::run::Shard;

/// A part as it is typed: `3/16`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShardArg(pub Shard);

impl FromStr for ShardArg {
    type Err = String;

    fn from_str(text: &str) -> Result<ShardArg, String> {
        let wrong = || format!("`{text}` is not a part: write 3/16 for the third of sixteen");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let number: u32 = number.trim().parse().map_err(|_| wrong())?;
        let of: u32 = of.trim().parse().map_err(|_| wrong())?;
        if number == 0 || number > of || of > 100_000 {
            return Err(wrong());
        }
        Ok(ShardArg(Shard { number, of }))
    }
}
