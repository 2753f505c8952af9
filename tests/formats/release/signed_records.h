#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "formats/base/random.h"
#include "formats/release/admission.h"
#include "formats/release/signatures.h"

namespace sightline {

inline SecretKey key_of(std::uint8_t number) {
  std::array<std::uint8_t, 32> seed{};
  seed.fill(number);
  return secret_key_from_seed(seed);
}

inline RootRecord root_of(const std::vector<std::uint8_t>& numbers, std::uint32_t threshold,
                          std::uint64_t version = 1) {
  RootRecord root;
  root.fleet = "metropolis";
  root.version = version;
  root.expires_s = 2'000'000'000;
  root.threshold = threshold;
  for (const std::uint8_t number : numbers) root.keys.push_back(public_key_of(key_of(number)));
  std::sort(root.keys.begin(), root.keys.end(),
            [](const PublicKey& a, const PublicKey& b) { return to_base64(a) < to_base64(b); });
  return root;
}

inline std::string signed_by(const std::string& text, const std::vector<std::uint8_t>& numbers) {
  std::string signatures;
  for (const std::uint8_t number : numbers) signatures += sign(text, key_of(number), "a test");
  return signatures;
}

inline Digest random_digest(Random& random) {
  Digest digest{};
  for (std::uint8_t& byte : digest) byte = static_cast<std::uint8_t>(random.below(256));
  return digest;
}

inline ReleaseRecord random_release(Random& random) {
  ReleaseRecord record;
  record.fleet = "metropolis";
  record.map_id = "map-" + std::to_string(random.below(1000));
  record.version = "2026." + std::to_string(random.below(100)) + " (test)";
  record.counter = 1 + random.below(1U << 30);
  record.expires_s = static_cast<std::int64_t>(random.next() % 253402300800U);
  record.minimum_minor = 0;
  record.sensor = random_digest(random);
  record.map_release = random.next();
  record.root_digest = random_digest(random);
  record.map = {"town-" + std::to_string(random.below(100)) + ".slmap", random.next(),
                random_digest(random)};
  const std::uint64_t deltas = random.below(4);
  for (std::uint64_t i = 0; i < deltas; ++i) {
    record.deltas.push_back(
        {{"d" + std::to_string(i), random.next(), random_digest(random)}, random_digest(random)});
  }
  std::sort(
      record.deltas.begin(), record.deltas.end(),
      [](const ReleasedDelta& a, const ReleasedDelta& b) { return a.base_sha256 < b.base_sha256; });
  return record;
}

}  // namespace sightline
