//! What a server answered, in a sentence.

use super::super::StoreError;
use object_store::Error;

/// The error of a call as the rest of the program knows it.
pub(super) fn store_error(doing: &'static str, path: &str, url: &str, error: &Error) -> StoreError {
    let text = chain(error);
    let remote = |reason: String| StoreError::Remote { doing, path: format!("{url}/{path}"), reason };
    match error {
        Error::AlreadyExists { .. } | Error::Precondition { .. } => StoreError::Exists { path: path.to_owned() },
        _ if is_without_bucket(&text) => {
            remote(format!("there is no such bucket or container ({}): create it, or name another", summary(error)))
        }
        Error::NotFound { .. } if doing != "write" => StoreError::NotFound { path: path.to_owned() },
        // Lists tell it in their own way.
        _ if text.contains("status code: 403") || text.contains("status code: 401") => {
            remote(format!("the server refuses these credentials ({}): {}", summary(error), credentials_of(url)))
        }
        // The address at which a machine of that cloud would be told who it is: asked where nothing else says so.
        _ if text.contains("169.254.169.254") || text.contains("metadata.google") || text.contains("169.254.170.2") => {
            remote(format!("there are no credentials: {}", credentials_of(url)))
        }
        _ => remote(format!("{}; run the same command again, it goes on from here", summary(error))),
    }
}

/// Which variables each cloud's own tools read.
fn credentials_of(url: &str) -> &'static str {
    match url.split("://").next() {
        Some("gs") => {
            "set GOOGLE_APPLICATION_CREDENTIALS to a key file, or run `gcloud auth application-default login`"
        }
        Some("az") => {
            "set AZURE_STORAGE_ACCOUNT with AZURE_STORAGE_KEY or AZURE_STORAGE_SAS_TOKEN, or AZURE_CLIENT_ID, \
             AZURE_CLIENT_SECRET and AZURE_TENANT_ID"
        }
        _ => "set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or AWS_PROFILE, and AWS_REGION as the bucket has it",
    }
}

/// Whether the call may be asked again because no answer came.
pub(super) fn is_broken_connection(error: &Error) -> bool {
    matches!(error, Error::Generic { .. }) && {
        let text = chain(error);
        let answered = text.contains("status code") || text.contains("Server returned");
        !answered
            && ["connection", "error sending request", "timed out", "body", "closed"].iter().any(|w| text.contains(w))
    }
}

fn is_without_bucket(text: &str) -> bool {
    ["NoSuchBucket", "ContainerNotFound", "The specified bucket does not exist"].iter().any(|w| text.contains(w))
}

/// The error with its sources, each once.
fn chain(error: &Error) -> String {
    let mut text = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(inner) = source {
        let said = inner.to_string();
        if !text.contains(&said) {
            text.push_str(": ");
            text.push_str(&said);
        }
        source = inner.source();
    }
    text
}

/// What matters of an error: the server's status with its own code and message, or the last of the reasons.
pub(super) fn summary(error: &Error) -> String {
    let text = chain(error);
    let between = |from: &str, to: &str| {
        let start = text.find(from)? + from.len();
        text[start..].find(to).map(|end| text[start..start + end].trim().to_owned())
    };
    let said = [between("<Code>", "</Code>"), between("<Message>", "</Message>")];
    let said = said.into_iter().flatten().collect::<Vec<_>>().join(": ");
    let status = between("status code: ", ":").or_else(|| between("status code: ", " "));
    let short = match (status, said.is_empty()) {
        (Some(status), true) => format!("the server answers {status}"),
        (Some(status), false) => format!("the server answers {status}, {said}"),
        (None, _) => text.rsplit(": ").next().unwrap_or(&text).to_owned(),
    };
    let line = short.split_whitespace().collect::<Vec<_>>().join(" ");
    line.trim_end_matches(['.', ' ']).chars().take(300).collect()
}
