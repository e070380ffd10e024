//! Files as another implementation of the format reads them.

use std::collections::HashMap;

use crate::written;

/// Number of messages of each topic.
fn counts<'a>(messages: impl Iterator<Item = mcap::Message<'a>>) -> HashMap<String, u64> {
    let mut counts = HashMap::new();
    for message in messages {
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    counts
}

#[test]
fn a_file_follows_the_format() {
    let bytes = written::bytes(40);
    let found = counts(mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap));
    for topic in ["/left/frame", "/left/image", "/left/reading", "/right_index/frame", "/right_index/reading"] {
        assert_eq!(found.get(topic), Some(&40), "{topic}");
    }
    assert_eq!(found["/right_index/log"], 1);
    assert_eq!((found["/left/calibration"], found["/left/transform"]), (1, 1));
}

#[test]
fn its_index_leads_to_every_message() {
    let bytes = written::bytes(40);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    let mut indexed = 0;
    for chunk in &summary.chunk_indexes {
        indexed += counts(summary.stream_chunk(&bytes, chunk).unwrap().map(Result::unwrap)).values().sum::<u64>();
        let by_channel = summary.read_message_indexes(&bytes, chunk).unwrap();
        for (channel, entries) in by_channel {
            for entry in entries {
                let message = summary.seek_message(&bytes, chunk, &entry).unwrap();
                assert_eq!(
                    (message.channel.topic.as_str(), message.log_time),
                    (channel.topic.as_str(), entry.log_time)
                );
            }
        }
    }
    assert_eq!(indexed, statistics.message_count);
    assert_eq!(indexed, statistics.channel_message_counts.values().sum::<u64>());
    let [left, _] = summary.attachment_indexes.as_slice() else { panic!("two profiles") };
    let attachment = mcap::read::attachment(&bytes, left).unwrap();
    assert_eq!(attachment.name, "left/profile.toml");
    assert_eq!(attachment.data.as_ref(), written::profile().to_toml().as_bytes());
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[1]).unwrap();
    assert_eq!(metadata.metadata["name"], "right index");
}
