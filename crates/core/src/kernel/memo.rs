//! What is prepared of a frame, shared by all machines that need the same of it.

use std::any::{Any, TypeId};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError, RwLock};

/// Everything that something prepared depends on, besides the frame.
pub trait MemoKey: PartialEq + Send + Sync + 'static {
    /// What is prepared.
    type Value: Send + Sync + 'static;

    /// Most values that are kept; further ones are made again each time.
    const MOST: usize;
}

/// The values of one type of key.
type Kept<K> = Mutex<Vec<(K, Arc<<K as MemoKey>::Value>)>>;

/// What has been prepared of one frame. It belongs to this frame alone.
#[derive(Default)]
pub struct Memo {
    kinds: RwLock<Vec<(TypeId, Arc<dyn Any + Send + Sync>)>>,
}

impl fmt::Debug for Memo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = self.kinds.read().unwrap_or_else(PoisonError::into_inner);
        write!(f, "Memo of {} kinds", kinds.len())
    }
}

impl Memo {
    /// The value of a key: found, or made and kept.
    ///
    /// It is made without a lock, since it may be made in parallel: who needs it at the same time
    /// makes it too, and one of the two is kept.
    pub fn get<K: MemoKey>(&self, key: K, make: impl FnOnce(&K) -> K::Value) -> Arc<K::Value> {
        if let Some(found) = self.find(&key) {
            return found;
        }
        let made = make(&key);
        self.keep(key, made)
    }

    /// The value of a key, if it was prepared.
    pub fn find<K: MemoKey>(&self, key: &K) -> Option<Arc<K::Value>> {
        let kept = self.kept::<K>();
        let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(own, _)| own == key).map(|(_, value)| Arc::clone(value))
    }

    /// Keeps the value of a key, unless there is one, or there are [`MemoKey::MOST`].
    pub fn keep<K: MemoKey>(&self, key: K, value: K::Value) -> Arc<K::Value> {
        let kept = self.kept::<K>();
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = kept.iter().find(|(own, _)| *own == key) {
            return Arc::clone(found);
        }
        let value = Arc::new(value);
        if kept.len() < K::MOST {
            kept.push((key, Arc::clone(&value)));
        }
        value
    }

    fn kept<K: MemoKey>(&self) -> Arc<Kept<K>> {
        let id = TypeId::of::<K>();
        let find = |kinds: &[(TypeId, Arc<dyn Any + Send + Sync>)]| {
            let (_, kept) = kinds.iter().find(|(own, _)| *own == id)?;
            Arc::clone(kept).downcast::<Kept<K>>().ok()
        };
        if let Some(kept) = find(&self.kinds.read().unwrap_or_else(PoisonError::into_inner)) {
            return kept;
        }
        let mut kinds = self.kinds.write().unwrap_or_else(PoisonError::into_inner);
        find(&kinds).unwrap_or_else(|| {
            let kept: Arc<Kept<K>> = Arc::default();
            kinds.push((id, kept.clone()));
            kept
        })
    }
}
