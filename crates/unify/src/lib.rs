//! Nothing but a manifest: one set of features for the dependencies that packages share.
