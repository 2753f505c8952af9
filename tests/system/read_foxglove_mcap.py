#!/usr/bin/env python3
"""Reads an MCAP file of `sightline export`, independently of the product, and checks what Foxglove needs of it.

usage: read_foxglove_mcap.py FILE
Checks every length, checksum, index and count of mcap.dev/spec, and each message against the JSON schema of its topic.
Prints topic, schema and number of messages of each topic, ascending.
"""
import base64
import json
import struct
import sys
import zlib

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, DATA_END = 11, 15


class Fields:
    """The fields of a record, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, form):
        (value,) = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return value

    def bytes(self, count=None):
        count = self.number("I") if count is None else count
        self.at += count
        assert self.at <= len(self.data)
        return self.data[self.at - count : self.at]

    def text(self):
        return self.bytes().decode()


def records(data, at, end):
    while at < end:
        op, length = struct.unpack_from("<BQ", data, at)
        assert at + 9 + length <= end
        yield at, op, Fields(data[at + 9 : at + 9 + length])
        at += 9 + length


def check(schema, value, place):
    """The keywords that the schemas use; another one is an error."""
    known = {"title", "type", "properties", "required", "items", "minItems", "maxItems", "minimum", "maximum", "oneOf", "const", "contentEncoding"}
    assert set(schema) <= known, f"{place}: {set(schema) - known}"
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    if "type" in schema:
        assert isinstance(value, kinds[schema["type"]]), f"{place}: {value!r} is no {schema['type']}"
        assert schema["type"] == "boolean" or not isinstance(value, bool), place
    if "oneOf" in schema:
        assert sum(value == choice["const"] for choice in schema["oneOf"]) == 1, f"{place}: {value!r}"
    assert "minimum" not in schema or value >= schema["minimum"], place
    assert "maximum" not in schema or value <= schema["maximum"], place
    if schema.get("contentEncoding") == "base64":
        base64.b64decode(value, validate=True)
    for name in schema.get("required", []):
        assert name in value, f"{place}: no {name}"
    if isinstance(value, dict):
        for name, member in value.items():
            check(schema["properties"][name], member, f"{place}.{name}")
    if isinstance(value, list):
        assert schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)), place
        for i, item in enumerate(value):
            check(schema["items"], item, f"{place}[{i}]")


def check_cloud(cloud):
    data = base64.b64decode(cloud["data"])
    assert len(data) % cloud["point_stride"] == 0 and len(data) > 0
    assert all(field["offset"] + 4 <= cloud["point_stride"] for field in cloud["fields"])


class Reader:
    def __init__(self, data):
        self.data, self.schemas, self.channels, self.counts = data, {}, {}, {}

    def read_chunk(self, fields):
        first, last = fields.number("Q"), fields.number("Q")
        size, crc = fields.number("Q"), fields.number("I")
        assert fields.text() == ""
        chunk = fields.bytes(fields.number("Q"))
        assert len(chunk) == size and zlib.crc32(chunk) == crc
        found = {}
        for at, op, record in records(chunk, 0, size):
            if op == SCHEMA:
                self.add_schema(record)
            elif op == CHANNEL:
                self.add_channel(record)
            elif op == MESSAGE:
                channel, time = self.add_message(record)
                assert first <= time <= last
                found.setdefault(channel, []).append((time, at))
        return found

    def add_schema(self, record):
        number = record.number("H")
        self.schemas[number] = (record.text(), record.text(), json.loads(record.text()))
        name, encoding, schema = self.schemas[number]
        assert encoding == "jsonschema" and schema["title"] == name

    def add_channel(self, record):
        number, schema = record.number("H"), record.number("H")
        self.channels[number] = (record.text(), schema)
        assert record.text() == "json"

    def add_message(self, record):
        channel, sequence = record.number("H"), record.number("I")
        time, published = record.number("Q"), record.number("Q")
        topic, number = self.channels[channel]
        assert time == published and sequence == self.counts.get(channel, 0)
        self.counts[channel] = sequence + 1
        message = json.loads(record.bytes(len(record.data) - record.at))
        name, _, schema = self.schemas[number]
        check(schema, message, topic)
        if "timestamp" in message:
            assert message["timestamp"]["sec"] * 10**9 + message["timestamp"]["nsec"] == time
        if name == "foxglove.PointCloud":
            check_cloud(message)
        return channel, time

    def read(self):
        data = self.data
        assert data.startswith(MAGIC) and data.endswith(MAGIC)
        chunks, indexes, pending = {}, {}, {}
        for at, op, fields in records(data, len(MAGIC), len(data) - len(MAGIC)):
            if op == CHUNK:
                pending = self.read_chunk(fields)
                chunks[at] = 9 + len(fields.data)
            elif op == MESSAGE_INDEX:
                channel = fields.number("H")
                entries = Fields(fields.bytes())
                assert sorted(pending.pop(channel)) == [(entries.number("Q"), entries.number("Q")) for _ in range(len(entries.data) // 16)]
            elif op == DATA_END:
                assert not pending and fields.number("I") == zlib.crc32(data[:at])
            elif op == CHUNK_INDEX:
                fields.at = 16
                place, length = fields.number("Q"), fields.number("Q")
                indexes[place] = length
            elif op == STATISTICS:
                assert fields.number("Q") == sum(self.counts.values())
                assert fields.number("H") == len(self.schemas) and fields.number("I") == len(self.channels)
            elif op == FOOTER:
                summary, _, crc = fields.number("Q"), fields.number("Q"), fields.number("I")
                assert crc == zlib.crc32(data[summary : at + 9 + 16])
        assert chunks == indexes and chunks


def main():
    with open(sys.argv[1], "rb") as file:
        reader = Reader(file.read())
    reader.read()
    for number, (topic, schema) in sorted(reader.channels.items(), key=lambda item: item[1]):
        print(topic, reader.schemas[schema][0], reader.counts[number])


if __name__ == "__main__":
    main()
