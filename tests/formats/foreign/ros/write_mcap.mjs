// Writes the MCAP files of recordings/ with the libraries of MCAP's and Foxglove's authors, which
// share no code with the reader. Only this script needs them, no test does:
//
//   npm install @mcap/core@2.2.2 @foxglove/rosmsg2-serialization@3.1.0 @foxglove/rosmsg@5.0.5 \
//       @foxglove/rosmsg-msgs-common@3.2.3 @foxglove/wasm-zstd@1.0.1
//   node write_mcap.mjs FOLDER_OF_node_modules recordings        writes the small files
//   node write_mcap.mjs FOLDER_OF_node_modules OUT.mcap PCD...   writes scans of /points, 10 a second
//
// LZ4 is packed by the program `lz4`. The same drive lies in drive.db3, by write_db3.py.

import { spawnSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";

const [, , modules, output, ...pcds] = process.argv;
const require = createRequire(path.resolve(modules, "any.js"));
const { McapWriter } = require("@mcap/core");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { parse } = require("@foxglove/rosmsg");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const zstd = require("@foxglove/wasm-zstd");

const FIRST_NS = 1567410201n * 1000000000n;
const LIVOX = `std_msgs/Header header
uint64 timebase
uint32 point_num
uint8 lidar_id
uint8[3] rsvd
CustomPoint[] points
===
MSG: livox_ros_driver2/CustomPoint
uint32 offset_time
float32 x
float32 y
float32 z
uint8 reflectivity
uint8 tag
uint8 line
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const VELODYNE = `std_msgs/Header header
VelodynePacket[] packets
===
MSG: velodyne_msgs/VelodynePacket
builtin_interfaces/Time stamp
uint8[1206] data
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
`;
const OWN_TYPES = { "livox_ros_driver2/CustomMsg": LIVOX, "velodyne_msgs/VelodyneScan": VELODYNE };

function definitionsOf(type) {
  if (OWN_TYPES[type]) return parse(OWN_TYPES[type], { ros2: true });
  const found = [];
  const add = (name) => {
    if (found.some((definition) => definition.name === name) || !ros2humble[name]) return;
    found.push(ros2humble[name]);
    for (const field of ros2humble[name].definitions) if (field.isComplex) add(field.type);
  };
  add(type);
  return [{ ...found[0], name: undefined }, ...found.slice(1)];
}

const time = (ns) => ({ sec: Number(ns / 1000000000n), nsec: Number(ns % 1000000000n) });
const ros2Time = (ns) => ({ sec: Number(ns / 1000000000n), nanosec: Number(ns % 1000000000n) });
const stamped = (ns, frame_id) => ({ stamp: { ...time(ns), ...ros2Time(ns) }, frame_id });
const vector = (x, y, z) => ({ x, y, z });
const turn = (z, w) => ({ x: 0, y: 0, z, w });

// Two rows of three points of 20 bytes with 4 bytes between them and 8 bytes behind each row.
function cloud(k) {
  const isBig = k === 3;
  const [step, row] = [24, 3 * 24 + 8];
  const data = new DataView(new ArrayBuffer(2 * row));
  for (let n = 0; n < 6; ++n) {
    const at = Math.floor(n / 3) * row + (n % 3) * step;
    [k + 1 + n, 2 - n, 0.5 * n, 10 * n].forEach((v, i) => data.setFloat32(at + 4 * i, v, !isBig));
    data.setUint32(at + 16, n * 10000000, !isBig);
  }
  const field = (name, offset, datatype) => ({ name, offset, datatype, count: 1 });
  return {
    header: stamped(FIRST_NS + BigInt(k) * 100000000n, "lidar"),
    height: 2,
    width: 3,
    fields: [field("x", 0, 7), field("y", 4, 7), field("z", 8, 7), field("intensity", 12, 7), field("t", 16, 6)],
    is_bigendian: isBig,
    point_step: step,
    row_step: row,
    data: new Uint8Array(data.buffer),
    is_dense: true,
  };
}

const transform = (ns, parent, child, translation, rotation) => ({
  header: stamped(ns, parent),
  child_frame_id: child,
  transform: { translation, rotation },
});

// [time, topic, type, message], in the order of time.
function drive() {
  const messages = [];
  const add = (ns, topic, type, message) => messages.push([ns, topic, type, message]);
  const mounting = transform(FIRST_NS, "base_link", "lidar", vector(1, 0, 2), turn(1, 0));
  add(FIRST_NS - 60000000n, "/tf_static", "tf2_msgs/TFMessage", { transforms: [mounting] });
  for (let j = -1; j <= 8; ++j) {
    const ns = FIRST_NS + BigInt(j) * 50000000n;
    const transforms = [transform(ns, "odom", "base_link", vector(0.5 * j, 0, 0), turn(0, 1))];
    add(ns, "/tf", "tf2_msgs/TFMessage", { transforms });
  }
  for (let j = -1; j <= 3; ++j) {
    const ns = FIRST_NS + BigInt(j) * 200000000n;
    const transforms = [transform(ns, "map", "odom", vector(100, 0, 0), turn(Math.SQRT1_2, Math.SQRT1_2))];
    add(ns, "/tf", "tf2_msgs/TFMessage", { transforms });
  }
  for (let k = 0; k < 4; ++k) {
    const ns = FIRST_NS + BigInt(k) * 100000000n;
    add(ns + 1000n, "/points", "sensor_msgs/PointCloud2", cloud(k));
    const pose = { position: vector(k, 2, 3), orientation: turn(1, 0) };
    const header = stamped(ns + 50000000n, "odom");
    const covariance = new Float64Array(36);
    add(ns + 50001000n, "/odom", "nav_msgs/Odometry", { header, child_frame_id: "base_link", pose: { pose, covariance } });
  }
  return messages.sort((a, b) => (a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0));
}

// A packet as the VLP-16's manual describes it: 12 blocks of an azimuth and 32 returns at 10 m.
function packet(first, hour_us) {
  const view = new DataView(new ArrayBuffer(1206));
  for (let block = 0; block < 12; ++block) {
    view.setUint16(100 * block, 0xffee);
    view.setUint16(100 * block + 2, first + 40 * block, true);
    for (let i = 0; i < 32; ++i) {
      view.setUint16(100 * block + 4 + 3 * i, 5000, true);
      view.setUint8(100 * block + 6 + 3 * i, 7);
    }
  }
  view.setUint32(1200, hour_us, true);
  view.setUint16(1204, 0x3722);
  return new Uint8Array(view.buffer);
}

function sensors() {
  const messages = [];
  for (let k = 0; k < 2; ++k) {
    const ns = FIRST_NS + BigInt(k) * 100000000n;
    const add = (topic, type, message) => messages.push([ns, topic, type, message]);
    const points = [0, 1, 2].map((n) => ({ offset_time: 5000000 * n, x: n + 1, y: n + 2, z: n + 3, reflectivity: 40 + n, tag: 16, line: n }));
    const livox = { header: stamped(ns, "livox"), timebase: ns, point_num: 3, lidar_id: 1, rsvd: [0, 0, 0], points };
    add("/livox/lidar", "livox_ros_driver2/CustomMsg", livox);
    const packets = [0n, 1327000n].map((after, i) => ({ stamp: { ...time(ns + after), ...ros2Time(ns + after) }, data: packet(480 * i, 1000) }));
    add("/velodyne_packets", "velodyne_msgs/VelodyneScan", { header: stamped(ns + 1327000n, "velodyne"), packets });
    const pose = { position: vector(k, 2, 3), orientation: turn(0.6, 0.8) };
    add("/pose", "geometry_msgs/PoseStamped", { header: stamped(ns, "map"), pose });
    const covariance = new Float64Array(36);
    add("/pose_with_covariance", "geometry_msgs/PoseWithCovarianceStamped", { header: stamped(ns, "map"), pose: { pose, covariance } });
    const fix = { status: { status: 0, service: 1 }, latitude: 49, longitude: 8.4, altitude: 112 };
    add("/fix", "sensor_msgs/NavSatFix", { header: stamped(ns, "gps"), ...fix });
  }
  return messages;
}

// The scans of the drive with two inertial units, of which one says where it sits: 100 times a second and with what goes
// wrong at times. Angular velocity of its message j: (j / 10, 2, -3) rad/s.
function imus() {
  const messages = [];
  const add = (ns, topic, type, message) => messages.push([ns, topic, type, message]);
  const sideways = { x: Math.SQRT1_2, y: 0, z: 0, w: Math.SQRT1_2 };
  const mountings = [
    transform(FIRST_NS, "base_link", "lidar", vector(1, 0, 2), turn(1, 0)),
    transform(FIRST_NS, "base_link", "imu_link", vector(0, 0, 1), sideways),
  ];
  add(FIRST_NS - 60000000n, "/tf_static", "tf2_msgs/TFMessage", { transforms: mountings });
  for (let k = 0; k < 4; ++k) {
    const ns = FIRST_NS + BigInt(k) * 100000000n;
    add(ns + 1000n, "/points", "sensor_msgs/PointCloud2", cloud(k));
  }
  const none = new Float64Array(9);
  const unknown = new Float64Array(9).fill(-1, 0, 1);
  const imu = (stamp_ns, frame, rate, covariance) => ({
    header: stamped(stamp_ns, frame),
    orientation: turn(0, 1),
    orientation_covariance: unknown,
    angular_velocity: rate,
    angular_velocity_covariance: covariance,
    linear_acceleration: vector(0, 0, 9.81),
    linear_acceleration_covariance: none,
  });
  for (let j = -2; j <= 32; ++j) {
    const ns = FIRST_NS + BigInt(j) * 10000000n;
    const rate = vector(j / 10, 2, j === 5 ? NaN : -3);
    // The tenth has the stamp of the ninth, the fifteenth that of one before the fourteenth.
    const stamp_ns = j === 10 ? ns - 10000000n : j === 15 ? ns - 15000000n : ns;
    add(ns + 500n, "/imu/data", "sensor_msgs/Imu", imu(stamp_ns, "imu_link", rate, j === 7 ? unknown : none));
    add(ns + 600n, "/camera/imu", "sensor_msgs/Imu", imu(ns, "camera_imu", vector(9, 9, 9), none));
    add(ns + 700n, "/camera/imu", "sensor_msgs/Imu", imu(ns + 100n, "camera_imu", vector(9, 9, 9), none));
  }
  return messages.sort((a, b) => (a[0] < b[0] ? -1 : a[0] > b[0] ? 1 : 0));
}

// Binary PCD with FIELDS x y z intensity of float32.
function cloudOfPcd(file, k) {
  const bytes = fs.readFileSync(file);
  const begin = bytes.indexOf("DATA binary\n") + "DATA binary\n".length;
  const header = bytes.subarray(0, begin).toString();
  if (!/FIELDS x y z intensity\n/.test(header)) throw new Error(`${file}: expected x y z intensity`);
  const count = Number(/POINTS (\d+)/.exec(header)[1]);
  const field = (name, offset) => ({ name, offset, datatype: 7, count: 1 });
  return {
    header: stamped(BigInt(k) * 100000000n, "velo_link"),
    height: 1,
    width: count,
    fields: [field("x", 0), field("y", 4), field("z", 8), field("intensity", 12)],
    is_bigendian: false,
    point_step: 16,
    row_step: 16 * count,
    data: new Uint8Array(bytes.subarray(begin, begin + 16 * count)),
    is_dense: true,
  };
}

const pack = {
  zstd: (data) => ({ compression: "zstd", compressedData: new Uint8Array(zstd.compress(data)) }),
  lz4: (data) => ({ compression: "lz4", compressedData: new Uint8Array(spawnSync("lz4", ["-c"], { input: data, maxBuffer: 1 << 30 }).stdout) }),
};

async function write(file, messages, options) {
  const parts = [];
  let size = 0n;
  const writable = {
    write: async (bytes) => {
      parts.push(Uint8Array.from(bytes));
      size += BigInt(bytes.length);
    },
    position: () => size,
  };
  const writer = new McapWriter({ writable, chunkSize: 1500, ...options });
  await writer.start({ profile: "ros2", library: "tests" });
  const channels = new Map();
  let sequence = 0;
  for (const [ns, topic, type, message] of messages) {
    if (!channels.has(topic)) {
      const name = type.replace("/", "/msg/");
      const data = new TextEncoder().encode(OWN_TYPES[type] ?? `# ${name}`);
      const schemaId = await writer.registerSchema({ name, encoding: "ros2msg", data });
      const id = await writer.registerChannel({ schemaId, topic, messageEncoding: "cdr", metadata: new Map() });
      channels.set(topic, { id, serializer: new MessageWriter(definitionsOf(type)) });
    }
    const { id, serializer } = channels.get(topic);
    await writer.addMessage({ channelId: id, sequence: sequence++, logTime: ns, publishTime: ns, data: serializer.writeMessage(message) });
  }
  await writer.end();
  fs.writeFileSync(file, Buffer.concat(parts));
}

await zstd.isLoaded;
if (pcds.length > 0) {
  const scans = pcds.map((file, k) => [BigInt(k) * 100000000n, "/points", "sensor_msgs/PointCloud2", cloudOfPcd(file, k)]);
  await write(output, scans, { compressChunk: pack.zstd, chunkSize: 4 << 20 });
} else {
  const bare = { useMessageIndex: false, useChunkIndex: false, useStatistics: false, useSummaryOffsets: false, repeatSchemas: false, repeatChannels: false };
  await write(`${output}/zstd.mcap`, drive(), { compressChunk: pack.zstd });
  await write(`${output}/lz4.mcap`, drive(), { compressChunk: pack.lz4 });
  await write(`${output}/none.mcap`, drive(), {});
  await write(`${output}/without_index.mcap`, drive(), { ...bare, compressChunk: pack.zstd });
  await write(`${output}/without_chunks.mcap`, drive(), { ...bare, useChunks: false });
  await write(`${output}/imus.mcap`, imus(), { compressChunk: pack.zstd });
  await write(`${output}/sensors.mcap`, sensors(), { compressChunk: pack.zstd });
}
