//! The tests of logs and blueprints.
//! One program: it links once, and its tests share the processors to the end.

mod blueprint_check;
mod blueprint_connection;
mod blueprint_coupling;
mod blueprint_record;
mod blueprint_text;
mod common;
mod log_csv_blocks;
mod log_csv_quotes;
mod log_matlab;
mod log_mdf;
mod log_read;
mod log_tdms;
#[path = "log_texts/main.rs"]
mod log_texts;
mod log_universal;
mod log_wav;
mod log_write;
mod real_logs;
