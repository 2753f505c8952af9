#!/usr/bin/env python3
"""Reads an MCAP file of `sightline localize` with the public modules mcap and mcap_ros2, which check its checksums.

usage: read_mcap.py FILE POSES_TUM      exit 77: a module is not installed
Prints the number of messages of each topic. Poses must be those of the TUM file, to the bit.
"""
import collections
import sys

try:
    from mcap.reader import SeekingReader, make_reader
    from mcap_ros2.decoder import DecoderFactory
except ImportError as missing:
    print(f"without the Python module {missing.name}")
    sys.exit(77)


def expected_poses(file):
    rows = [line.split() for line in open(file) if not line.startswith("#")]
    return [tuple(float(word) for word in row[1:4]) for row in rows]


def main():
    counts = collections.Counter()
    poses = []
    with open(sys.argv[1], "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert isinstance(reader, SeekingReader)
        summary = reader.get_summary()
        assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 0
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            counts[channel.topic] += 1
            assert schema.encoding == "ros2msg" and channel.message_encoding == "cdr"
            if channel.topic == "/sightline/pose":
                place = decoded.pose.pose.position
                poses.append((place.x, place.y, place.z))
                assert len(decoded.pose.covariance) == 36
                stamp = decoded.header.stamp
                assert stamp.sec * 1_000_000_000 + stamp.nanosec == message.log_time
            if channel.topic == "/diagnostics":
                assert [value.key for value in decoded.status[0].values][:2] == ["scan", "look"]
        for channel_id, count in summary.statistics.channel_message_counts.items():
            assert counts[summary.channels[channel_id].topic] == count
    assert poses == expected_poses(sys.argv[2])
    for topic, count in sorted(counts.items()):
        print(topic, count)


if __name__ == "__main__":
    main()
