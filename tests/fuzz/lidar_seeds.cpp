#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include "tests/fuzz/seed.h"

// Small sensors: few beams, and heads that turn by large steps.

namespace sightline {
namespace {

std::string big16(unsigned value) {
  return {static_cast<char>(value >> 8U), static_cast<char>(value & 255U)};
}

// IPv4 within Ethernet; `fragment`: flags and offset.
std::string record(std::uint32_t us, unsigned number, unsigned fragment, const std::string& body) {
  std::string frame = std::string(12, '\1') + big16(0x0800) + "\x45" + '\0';
  frame += big16(20 + static_cast<unsigned>(body.size())) + big16(number) + big16(fragment);
  frame += "\x40\x11" + std::string(10, '\0') + body;
  const auto length = static_cast<std::uint32_t>(frame.size());
  return raw(std::array<std::uint32_t, 4>{1'700'000'000, us, length, length}) + frame;
}

std::string udp(const std::string& payload, unsigned port = 7502) {
  const auto size = static_cast<unsigned>(payload.size());
  return big16(port) + big16(port) + big16(8 + size) + big16(0) + payload;
}

std::string capture() {
  return raw(std::array<std::uint32_t, 6>{0xa1b2c3d4U, 0x00040002U, 0U, 0U, 0x40000U, 1U});
}

// Two columns a packet of two beams; `pixel` is one of them.
std::string ouster_packet(bool is_legacy, std::uint16_t frame, std::uint16_t first,
                          const std::string& pixel) {
  std::string bytes = is_legacy ? "" : raw(std::uint16_t{1}) + raw(frame) + std::string(28, '\0');
  for (std::uint16_t i = 0; i < 2; ++i) {
    const auto id = static_cast<std::uint16_t>(first + i);
    const std::uint64_t time_ns = 1'000'000ULL * (8ULL * frame + id);
    bytes += raw(time_ns) + raw(id);
    bytes += is_legacy ? raw(frame) + raw(std::uint32_t{0}) : raw(std::uint16_t{1});
    bytes += pixel + pixel;
    if (is_legacy) bytes += raw(0xffffffffU);
  }
  return is_legacy ? bytes : bytes + std::string(32, '\0');
}

std::string ouster_metadata(const std::string& profile) {
  return R"({"data_format":{"columns_per_frame":8,"columns_per_packet":2,"column_window":[0,7],)"
         R"("udp_profile_lidar":")" +
         profile +
         R"("},"beam_altitude_angles":[10,-10],"beam_azimuth_angles":[1,-1],)"
         R"("lidar_origin_to_beam_origin_mm":15.8,"lidar_to_sensor_transform":)"
         R"([-1,0,0,0,0,-1,0,0,0,0,1,36.2,0,0,0,1]})";
}

std::string ouster(const std::string& profile, const std::string& pixel, bool is_in_fragments) {
  std::string file = capture();
  unsigned number = 1;
  for (std::uint16_t frame = 1; frame < 3; ++frame) {
    for (std::uint16_t first = 0; first < 8; first += 2) {
      const std::string datagram = udp(ouster_packet(profile == "LEGACY", frame, first, pixel));
      const std::uint32_t us = 1000U * (8U * frame + first);
      if (is_in_fragments) {
        file += record(us, number, 0x2000, datagram.substr(0, 40));
        file += record(us, number, 5, datagram.substr(40));
      } else {
        file += record(us, number, 0, datagram);
      }
      ++number;
    }
  }
  return file;
}

// Blocks of 30 degrees: a turn is 12 of them.
std::string hesai_blocks(unsigned index, unsigned blocks, unsigned channels, std::size_t unit) {
  std::string bytes;
  for (unsigned block = 0; block < blocks; ++block) {
    bytes += raw(static_cast<std::uint16_t>(3000 * ((index * blocks + block) % 12)));
    for (unsigned i = 0; i < channels; ++i) {
      bytes += raw(std::uint16_t{2500}) + std::string(unit - 2, '\7');
    }
  }
  return bytes;
}

std::string hesai(bool is_pandar64, char mode) {
  std::string file = capture();
  for (unsigned i = 0; i < 6; ++i) {
    const std::uint32_t us = 400 * i;
    std::string packet = "\xee\xff";
    if (is_pandar64) {
      packet += std::string("\x40\6\0\4\0\0", 6) + hesai_blocks(i, 6, 64, 3);
      packet += std::string(10, '\0') + raw(us) + mode + '\0' + std::string("\x17\1\2\3\4\5", 6);
    } else {
      packet += std::string("\6\1\0\0\x10\x8\1\4\2\0", 10) + hesai_blocks(i, 8, 16, 4);
      packet +=
          std::string(10, '\0') + mode + std::string("\0\0\x7b\1\2\3\4\5", 8) + raw(us) + '\0';
    }
    file += record(us, i, 0, udp(packet));
  }
  return file;
}

// Of one turn that takes 6 packets; in high resolution, with confidences and functional safety.
std::string pandar128(char mode) {
  std::string file = capture();
  for (unsigned i = 0; i < 7; ++i) {
    std::string packet = std::string("\xee\xff\1\4\0\0\x80\2\0\4\1\x15", 12);
    packet += hesai_blocks(i, 2, 128, 4) + std::string(4 + 17, '\3');
    packet += std::string(12, '\0') + mode + std::string("\x58\2\x7b\1\2\3\4\5", 8);
    file += record(400 * i, i, 0, udp(packet + raw(std::uint32_t{400} * i) + '\0'));
  }
  return file;
}

std::string correction(int channels) {
  std::string text = "Channel,Elevation,Azimuth\n";
  for (int i = 1; i <= channels; ++i) {
    const int elevation_deg = channels > 64 ? 10 - i / 2 : 10 - i;
    text += std::to_string(i) + "," + std::to_string(elevation_deg) + ",1.5\n";
  }
  return text;
}

std::string velodyne_packet(unsigned azimuth_cdeg, std::uint32_t hour_us, char product) {
  std::string bytes;
  for (unsigned block = 0; block < 12; ++block) {
    bytes += "\xff\xee" + raw(static_cast<std::uint16_t>((azimuth_cdeg + 3000 * block) % 36000));
    for (unsigned i = 0; i < 32; ++i) bytes += raw(std::uint16_t{5000}) + '\1';
  }
  return bytes + raw(hour_us) + '\x37' + product;
}

std::string velodyne(char product) {
  std::string file = capture();
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::string packet = velodyne_packet(18000 + 1000 * i, 800'000'000 + 1327 * i, product);
    file += record(1327 * i, 0, 0, udp(packet, 2368));
  }
  return file;
}

// A section, an interface and a block for each packet.
std::string pcapng(const std::string& classic) {
  const auto block = [](std::uint32_t type, std::string body) {
    body.resize((body.size() + 3) / 4 * 4);
    const auto length = static_cast<std::uint32_t>(body.size() + 12);
    return raw(type) + raw(length) + body + raw(length);
  };
  std::string file = block(0x0a0d0d0a, raw(0x1a2b3c4dU) + raw(1U) + std::string(8, '\xff'));
  file += block(1, raw(1U) + raw(0U));
  for (std::size_t at = 24; at < classic.size();) {
    std::array<std::uint32_t, 4> head{};
    std::memcpy(head.data(), classic.data() + at, sizeof head);
    const std::uint64_t us = head[0] * std::uint64_t{1'000'000} + head[1];
    file += block(6, raw(0U) + raw(static_cast<std::uint32_t>(us >> 32U)) +
                         raw(static_cast<std::uint32_t>(us)) + raw(head[2]) + raw(head[3]) +
                         classic.substr(at + 16, head[2]));
    at += 16 + head[2];
  }
  return file;
}

}  // namespace

// The first byte decides fuzz_lidars whose packets they are; then what lies beside the capture,
// behind its length in 32 bits.
void add_lidar_seeds(std::vector<Seed>& seeds) {
  const std::string pixel12 = raw(std::uint32_t{5000}) + std::string(8, '\5');
  const auto add = [&](const std::string& name, char kind, const std::string& beside,
                       const std::string& file) {
    add_seed(seeds, "lidars/seed_" + name, kind, sized(beside) + file);
  };
  add("ouster_legacy", 0, ouster_metadata("LEGACY"), ouster("LEGACY", pixel12, true));
  add("ouster_single", 0, ouster_metadata("RNG19_RFL8_SIG16_NIR16"),
      ouster("RNG19_RFL8_SIG16_NIR16", pixel12, false));
  add("ouster_dual", 0, ouster_metadata("RNG19_RFL8_SIG16_NIR16_DUAL"),
      ouster("RNG19_RFL8_SIG16_NIR16_DUAL",
             raw(std::uint32_t{5000}) + raw(std::uint32_t{4000}) + std::string(8, '\5'), false));
  add("ouster_low", 0, ouster_metadata("RNG15_RFL8_NIR8"),
      ouster("RNG15_RFL8_NIR8", raw(std::uint16_t{600}) + "\5\5", false));
  add("hesai_pandar64", 1, correction(64), hesai(true, '\x37'));
  add("hesai_xt16", 1, correction(16), hesai(false, '\x37'));
  add("hesai_xt16_dual", 1, "", hesai(false, '\x39'));
  add("hesai_pandar128", 1, correction(128), pandar128('\x37'));
  add("hesai_alone", 2, "", hesai(true, '\x39'));
  add_seed(seeds, "pcap/seed_vlp16", velodyne('\x22'));
  add_seed(seeds, "pcap/seed_hdl32", velodyne('\x21'));
  add_seed(seeds, "pcap/seed_pcapng", pcapng(velodyne('\x22')));
}

}  // namespace sightline
