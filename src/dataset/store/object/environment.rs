//! Clients with the credentials that the environment has, as each cloud's own tools read them.

use object_store::aws::{AmazonS3Builder, S3CopyIfNotExists};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::{BackoffConfig, ClientOptions, Error, ObjectStore, RetryConfig};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// A client of the bucket or container.
pub(super) fn client(url: &str, bucket: &str, patience: Duration) -> Result<Arc<dyn ObjectStore>, Error> {
    // Another of the process's libraries may have chosen one before; any will do.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let options = ClientOptions::new()
        .with_timeout(Duration::from_secs(300))
        .with_connect_timeout(Duration::from_secs(10))
        .with_read_timeout(Duration::from_secs(60));
    let backoff =
        BackoffConfig { init_backoff: Duration::from_millis(100), max_backoff: Duration::from_secs(15), base: 2.0 };
    let retry = RetryConfig { backoff, max_retries: 1000, retry_timeout: patience };
    Ok(match url.split("://").next() {
        Some("gs") => {
            let mut builder = GoogleCloudStorageBuilder::new().with_client_options(options);
            for (key, value) in variables("GOOGLE_") {
                if let Ok(known) = key.parse() {
                    builder = builder.with_config(known, value);
                }
            }
            Arc::new(builder.with_retry(retry).with_bucket_name(bucket).build()?)
        }
        Some("az") => {
            let mut builder = MicrosoftAzureBuilder::new().with_client_options(options);
            for (key, value) in variables("AZURE_") {
                let known = match key.as_str() {
                    // As `az` and the SDKs call them.
                    "azure_storage_account" => Some(AzureConfigKey::AccountName),
                    "azure_storage_key" => Some(AzureConfigKey::AccessKey),
                    other => other.parse().ok(),
                };
                if let Some(known) = known {
                    builder = builder.with_config(known, value);
                }
            }
            Arc::new(builder.with_retry(retry).with_container_name(bucket).build()?)
        }
        _ => {
            let mut builder = AmazonS3Builder::new().with_client_options(options);
            let mut plain_http = false;
            for (key, value) in variables("AWS_") {
                plain_http |= key.starts_with("aws_endpoint_url") && value.starts_with("http://");
                if let Ok(known) = key.parse() {
                    builder = builder.with_config(known, value);
                }
            }
            if plain_http {
                builder = builder.with_allow_http(true);
            }
            for (key, value) in profile() {
                if let Ok(known) = key.parse() {
                    builder = builder.with_config(known, value);
                }
            }
            builder = builder.with_copy_if_not_exists(S3CopyIfNotExists::Multipart);
            Arc::new(builder.with_retry(retry).with_bucket_name(bucket).build()?)
        }
    })
}

/// Variables of the environment by their names in lower case.
fn variables(prefix: &str) -> Vec<(String, String)> {
    let text = |(key, value): (std::ffi::OsString, std::ffi::OsString)| {
        Some((key.into_string().ok()?, value.into_string().ok()?))
    };
    let all = std::env::vars_os().filter_map(text);
    all.filter(|(key, _)| key.starts_with(prefix)).map(|(key, value)| (key.to_ascii_lowercase(), value)).collect()
}

/// What `AWS_PROFILE` says in the shared files, where no variable says who we are.
fn profile() -> Vec<(String, String)> {
    let is_set = |key: &str| std::env::var_os(key).is_some();
    let told = [
        "AWS_ACCESS_KEY_ID",
        "AWS_WEB_IDENTITY_TOKEN_FILE",
        "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
        "AWS_CONTAINER_CREDENTIALS_FULL_URI",
    ];
    if told.into_iter().any(is_set) {
        return Vec::new();
    }
    let name = std::env::var("AWS_PROFILE").unwrap_or_else(|_| "default".to_owned());
    let file = |variable: &str, usual: &str| {
        let named = std::env::var_os(variable).map(PathBuf::from);
        named.or_else(|| std::env::var_os("HOME").map(|home| PathBuf::from(home).join(usual)))
    };
    let read = |path: Option<PathBuf>, section: &str| {
        let text = path.and_then(|p| std::fs::read_to_string(p).ok()).unwrap_or_default();
        section_of(&text, section)
    };
    let mut found = read(file("AWS_SHARED_CREDENTIALS_FILE", ".aws/credentials"), &name);
    let section = if name == "default" { name } else { format!("profile {name}") };
    let region = read(file("AWS_CONFIG_FILE", ".aws/config"), &section);
    if !["AWS_REGION", "AWS_DEFAULT_REGION"].into_iter().any(is_set) {
        found.extend(region.into_iter().filter(|(key, _)| key == "aws_region"));
    }
    found
}

/// The keys of a section that say who we are and where.
fn section_of(text: &str, section: &str) -> Vec<(String, String)> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            inside = name.trim() == section;
        } else if let Some((key, value)) = line.split_once('=').filter(|_| inside) {
            let key = key.trim();
            let key = if key == "region" { "aws_region" } else { key };
            if ["aws_access_key_id", "aws_secret_access_key", "aws_session_token", "aws_region"].contains(&key) {
                found.push((key.to_owned(), value.trim().to_owned()));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_is_read_as_it_is_written() {
        let text = "# mine\n[default]\naws_access_key_id = A\n[work]\naws_access_key_id=B\n aws_secret_access_key = c=d\nregion = eu-west-1\ncolour = red\n";
        let pairs = |section| section_of(text, section);
        assert_eq!(pairs("default"), [("aws_access_key_id".to_owned(), "A".to_owned())]);
        let work = [("aws_access_key_id", "B"), ("aws_secret_access_key", "c=d"), ("aws_region", "eu-west-1")];
        assert_eq!(pairs("work"), work.map(|(k, v)| (k.to_owned(), v.to_owned())));
        assert_eq!(pairs("wor"), []);
    }
}
