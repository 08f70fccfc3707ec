//! A store in object storage: Amazon S3 and what speaks like it, Google Cloud Storage, Azure Blob Storage.
//!
//! The only room that knows `object_store` and its runtime: calls block, so that the rest of the program need not know
//! that somebody is waiting for a network. An object appears whole or not at all by the nature of these stores; that it
//! appears once is asked of the server with each put. Several machines may write into one dataset, and no lock holds
//! them apart: see [`Store::is_shared`].

mod environment;
mod told;

use super::{Chunks, Entry, Store, StoreError, UNFINISHED, check_path};
use futures_util::StreamExt as _;
use object_store::path::Path;
use object_store::{Error, GetOptions, GetRange, ObjectStoreExt as _, PutMode, PutPayload, WriteMultipart};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tokio::runtime::Runtime;

/// Larger contents go in parts.
const ONE_REQUEST_BYTES: usize = 32 << 20;
/// Parts: of the ten thousand that S3 takes of one object, so 320 GB.
const PART_BYTES: usize = 32 << 20;
/// Parts on their way at once.
const PARTS_IN_FLIGHT: usize = 4;
/// How long a server that fails is asked again, unless [`PATIENCE`] says otherwise, s.
const PATIENCE_S: u64 = 180;
/// The variable of the environment that does.
const PATIENCE: &str = "SATSEED_STORE_PATIENCE_S";

/// Files in a bucket or container, below a prefix.
pub struct ObjectStore {
    client: Arc<dyn object_store::ObjectStore>,
    root: Path,
    /// As given, without a slash at its end.
    url: String,
    runtime: Runtime,
    patience: Duration,
    /// Of this process, for names of unfinished objects.
    owner: String,
    counter: AtomicU64,
}

impl ObjectStore {
    /// Whether a place is in object storage.
    pub fn is_url(place: &str) -> bool {
        ["s3://", "gs://", "az://"].iter().any(|scheme| place.starts_with(scheme))
    }

    /// The store of `s3://bucket/prefix`, `gs://bucket/prefix` or `az://container/prefix`, with the credentials of the
    /// environment. Nothing is asked of the server yet.
    ///
    /// # Errors
    /// Where the address is none, or the environment has what cannot be.
    pub fn open(url: &str) -> Result<Self, StoreError> {
        let bad = |why: &str| StoreError::BadPlace { place: url.chars().take(200).collect(), why: why.to_owned() };
        let patience_s = match std::env::var(PATIENCE) {
            Ok(text) => text.parse().map_err(|_| bad(&format!("{PATIENCE} is `{text}` and should be seconds")))?,
            Err(_) => PATIENCE_S,
        };
        let patience = Duration::from_secs(patience_s);
        let (_, rest) = url.split_once("://").ok_or_else(|| bad("it begins with s3://, gs:// or az://"))?;
        let rest = rest.trim_end_matches('/');
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if bucket.is_empty() {
            return Err(bad("write s3://BUCKET/PREFIX, gs://BUCKET/PREFIX or az://CONTAINER/PREFIX"));
        }
        let legal = |part: &str| {
            let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.' | b'=' | b'+');
            !part.is_empty() && part != "." && part != ".." && part.bytes().all(plain)
        };
        if !prefix.is_empty() && !prefix.split('/').all(legal) {
            return Err(bad("a prefix holds letters, digits, `_`, `-`, `.`, `=`, `+`, and one `/` between its parts"));
        }
        let client = environment::client(url, bucket, patience).map_err(|e| bad(&told::summary(&e)))?;
        Self::new(client, prefix, url.trim_end_matches('/'), patience)
    }

    /// A store over any client.
    fn new(
        client: Arc<dyn object_store::ObjectStore>,
        prefix: &str,
        url: &str,
        patience: Duration,
    ) -> Result<Self, StoreError> {
        let bad = |why: String| StoreError::BadPlace { place: url.to_owned(), why };
        let root = Path::parse(prefix).map_err(|e| bad(e.to_string()))?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .thread_name("satseed-store")
            .enable_all()
            .build()
            .map_err(|e| bad(format!("no threads for its connections: {e}")))?;
        let owner = blake3::hash(format!("{:?} {}", std::time::SystemTime::now(), std::process::id()).as_bytes());
        let owner = owner.to_hex()[..16].to_owned();
        Ok(Self { client, root, url: url.to_owned(), runtime, patience, owner, counter: AtomicU64::new(0) })
    }

    /// The key of a checked path.
    fn key(&self, path: &str) -> Result<Path, StoreError> {
        check_path(path)?;
        Ok(self.below(path))
    }

    fn below(&self, path: &str) -> Path {
        path.split('/').fold(self.root.clone(), Path::join)
    }

    /// Asks until the server answers. What it answers it answers for good: servers that fail or ask for patience are
    /// asked again by the client itself, with back-off. Here it is the connections that break on the way.
    fn asked<T>(&self, mut ask: impl AsyncFnMut() -> Result<T, Error>) -> Result<T, Error> {
        let (began, mut pause) = (Instant::now(), Duration::from_millis(200));
        loop {
            match self.runtime.block_on(ask()) {
                Err(error) if told::is_broken_connection(&error) && began.elapsed() + pause < self.patience => {
                    std::thread::sleep(pause);
                    pause = (pause * 2).min(Duration::from_secs(15));
                }
                answer => return answer,
            }
        }
    }

    fn failed(&self, doing: &'static str, path: &str, error: &Error) -> StoreError {
        told::store_error(doing, path, &self.url, error)
    }

    fn create(&self, key: &Path, path: &str, content: Vec<u8>) -> Result<(), StoreError> {
        let payload = PutPayload::from(content);
        let put = async || self.client.put_opts(key, payload.clone(), PutMode::Create.into()).await;
        self.asked(put).map(|_| ()).map_err(|e| self.failed("write", path, &e))
    }

    /// Uploads in parts: the object appears when all of them are there, in place of one that had its name.
    fn upload(&self, key: &Path, path: &str, chunks: &mut Chunks<'_>) -> Result<(), StoreError> {
        let failed = |e: Error| self.failed("write", path, &e);
        let begun = self.asked(async || self.client.put_multipart(key).await).map_err(failed)?;
        let mut upload = WriteMultipart::new_with_chunk_size(begun, PART_BYTES);
        for chunk in chunks {
            let written = chunk.and_then(|chunk| {
                let put = async {
                    upload.wait_for_capacity(PARTS_IN_FLIGHT).await?;
                    upload.put(chunk.into());
                    Ok(())
                };
                self.runtime.block_on(put).map_err(failed)
            });
            if let Err(error) = written {
                // The error at hand says more; what is left of the parts nobody sees, and the bucket's own rule clears.
                let _ = self.runtime.block_on(upload.abort());
                return Err(error);
            }
        }
        self.runtime.block_on(upload.finish()).map(|_| ()).map_err(failed)
    }
}

impl std::fmt::Debug for ObjectStore {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ObjectStore").field("url", &self.url).finish_non_exhaustive()
    }
}

impl Store for ObjectStore {
    fn put(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let key = self.key(path)?;
        if bytes.len() <= ONE_REQUEST_BYTES {
            return self.create(&key, path, bytes.to_vec());
        }
        if self.size(path)?.is_some() {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        // Parts make an object in place of another, so they make one that is nobody's, and a copy that refuses to replace
        // gives it its name.
        let number = self.counter.fetch_add(1, Ordering::Relaxed);
        let temporary = self.root.clone().join(format!("{UNFINISHED}{}-{number}", self.owner));
        let mut parts = bytes.chunks(PART_BYTES).map(|part| Ok(part.to_vec()));
        self.upload(&temporary, path, &mut parts)?;
        let copied = self.asked(async || self.client.copy_if_not_exists(&temporary, &key).await);
        let _ = self.asked(async || self.client.delete(&temporary).await);
        copied.map_err(|e| self.failed("write", path, &e))
    }

    fn put_chunks(&self, path: &str, chunks: &mut Chunks<'_>) -> Result<(), StoreError> {
        let key = self.key(path)?;
        let mut first = Vec::new();
        while first.len() <= ONE_REQUEST_BYTES {
            match chunks.next() {
                Some(chunk) => first.extend(chunk?),
                None => return self.put(path, &first),
            }
        }
        // Too large for a copy, perhaps. One who joins a dataset writes alone, so this look is enough.
        if self.size(path)?.is_some() {
            return Err(StoreError::Exists { path: path.to_owned() });
        }
        self.upload(&key, path, &mut [Ok(first)].into_iter().chain(chunks))
    }

    fn get(&self, path: &str) -> Result<Vec<u8>, StoreError> {
        let key = self.key(path)?;
        let get = async || self.client.get(&key).await?.bytes().await;
        self.asked(get).map(Vec::from).map_err(|e| self.failed("read", path, &e))
    }

    fn get_chunks(&self, path: &str, each: &mut dyn FnMut(&[u8])) -> Result<(), StoreError> {
        let key = self.key(path)?;
        let mut done = 0_u64;
        self.asked(async || {
            let range = (done > 0).then_some(GetRange::Offset(done));
            let mut stream =
                self.client.get_opts(&key, GetOptions { range, ..GetOptions::default() }).await?.into_stream();
            while let Some(piece) = stream.next().await {
                let piece = piece?;
                each(&piece);
                done += piece.len() as u64;
            }
            Ok(())
        })
        .map_err(|e| self.failed("read", path, &e))
    }

    fn size(&self, path: &str) -> Result<Option<u64>, StoreError> {
        let key = self.key(path)?;
        match self.asked(async || self.client.head(&key).await) {
            Ok(object) => Ok(Some(object.size)),
            Err(e) => match self.failed("look at", path, &e) {
                StoreError::NotFound { .. } => Ok(None),
                other => Err(other),
            },
        }
    }

    fn list(&self, prefix: &str) -> Result<Vec<Entry>, StoreError> {
        let below = if prefix.is_empty() { self.root.clone() } else { self.key(prefix)? };
        let from = (!below.as_ref().is_empty()).then_some(&below);
        let list = async || self.client.list(from).collect::<Vec<_>>().await.into_iter().collect::<Result<Vec<_>, _>>();
        let objects = self.asked(list).map_err(|e| self.failed("list", prefix, &e))?;
        let root = self.root.as_ref();
        let mut entries: Vec<Entry> = objects
            .into_iter()
            .filter_map(|object| {
                let path = object.location.as_ref().strip_prefix(root)?.trim_start_matches('/').to_owned();
                (!path.starts_with(UNFINISHED)).then_some(Entry { path, bytes: Some(object.size) })
            })
            .collect();
        if entries.is_empty() && !prefix.is_empty() {
            entries.extend(self.size(prefix)?.map(|bytes| Entry { path: prefix.to_owned(), bytes: Some(bytes) }));
        }
        entries.sort();
        Ok(entries)
    }

    fn discard(&self, path: &str) -> Result<(), StoreError> {
        let key = self.key(path)?;
        if self.size(path)?.is_none() {
            return Err(StoreError::NotFound { path: path.to_owned() });
        }
        self.asked(async || self.client.delete(&key).await).map_err(|e| self.failed("remove", path, &e))
    }

    fn clear_unfinished(&self) -> Result<(), StoreError> {
        let failed = |e: Error| self.failed("clear what is unfinished in", "", &e);
        let root = (!self.root.as_ref().is_empty()).then_some(&self.root);
        // One level only: the dataset's own objects stand in folders, and there may be very many.
        let top = self.asked(async || self.client.list_with_delimiter(root).await).map_err(failed)?;
        for object in top.objects {
            if object.location.filename().is_some_and(|name| name.starts_with(UNFINISHED)) {
                self.asked(async || self.client.delete(&object.location).await).map_err(failed)?;
            }
        }
        Ok(())
    }

    fn is_shared(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::conforms;
    use super::*;

    fn in_memory(prefix: &str) -> ObjectStore {
        let client = Arc::new(object_store::memory::InMemory::new());
        ObjectStore::new(client, prefix, "s3://bucket", Duration::from_secs(1)).unwrap()
    }

    #[test]
    fn objects_conform() {
        conforms(&in_memory("some/prefix"), false);
        conforms(&in_memory(""), false);
    }

    #[test]
    fn what_a_dead_writer_left_is_not_seen_and_cleared() {
        let store = in_memory("p");
        let left = store.root.clone().join(format!("{UNFINISHED}0123-0"));
        store.create(&left, "-", b"half".to_vec()).unwrap();
        store.put("recipe.toml", b"r").unwrap();
        assert_eq!(store.list("").unwrap().len(), 1);
        store.clear_unfinished().unwrap();
        let all = store.runtime.block_on(store.client.list(None).collect::<Vec<_>>());
        assert_eq!(all.len(), 1);
    }

    /// Against a server, where `tests/python/s3.py` has started one and says so.
    #[test]
    fn a_server_conforms() {
        if let Ok(url) = std::env::var("SATSEED_TEST_STORE") {
            conforms(&ObjectStore::open(&url).unwrap(), false);
        }
    }

    #[test]
    fn bad_places_are_told() {
        for (place, what) in [
            ("s3://", "BUCKET/PREFIX"),
            ("s3:///x", "BUCKET/PREFIX"),
            ("s3://b/a//b", "one `/`"),
            ("s3://b/../c", "one `/`"),
            ("gs://b/ü", "one `/`"),
        ] {
            let error = ObjectStore::open(place).unwrap_err().to_string();
            assert!(error.contains(what) && error.contains(place), "{error}");
        }
    }
}
