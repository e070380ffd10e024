//! Values that are shared and then reused, so that no frame allocates memory.

use std::sync::Arc;

/// A pool that grows up to a limit.
#[derive(Debug)]
pub(crate) struct Pool<T> {
    items: Vec<Arc<T>>,
    limit: usize,
}

impl<T> Pool<T> {
    /// A pool of at most `limit` values.
    pub(crate) fn new(limit: usize) -> Self {
        Self { items: Vec::with_capacity(limit), limit }
    }

    /// An unused value, to be filled and then shared; `make` creates new ones up to the limit. `None` if all are in
    /// use.
    pub(crate) fn free(&mut self, make: impl FnOnce() -> T) -> Option<&mut Arc<T>> {
        let free = self.items.iter_mut().position(|item| Arc::get_mut(item).is_some());
        let index = match free {
            Some(index) => index,
            None if self.items.len() < self.limit => {
                self.items.push(Arc::new(make()));
                self.items.len() - 1
            }
            None => return None,
        };
        Some(&mut self.items[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_used_again_once_nobody_holds_it() {
        let mut pool = Pool::new(2);
        let first = pool.free(Vec::<u8>::new).unwrap().clone();
        let second = pool.free(Vec::<u8>::new).unwrap().clone();
        assert!(!Arc::ptr_eq(&first, &second) && pool.free(Vec::<u8>::new).is_none());
        drop(first);
        let third = pool.free(Vec::<u8>::new).unwrap();
        Arc::get_mut(third).unwrap().push(7);
        assert!(!Arc::ptr_eq(third, &second));
    }
}
