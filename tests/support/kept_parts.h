#pragma once

#include <gtest/gtest.h>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "passes/pass/pass_context.h"

namespace sightline {

// Keeps the parts that a pass makes by their content, as a compile's cache does, over several runs.
class KeptParts {
 public:
  PassContext context() {
    made_.clear();
    names_.clear();
    PassContext ctx;
    ctx.parts_sink = [this](std::span<const PartName> names) {
      names_.insert(names_.end(), names.begin(), names.end());
    };
    ctx.saved_part = [this](const PartName& part) -> std::optional<std::vector<std::byte>> {
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto found = part.content ? parts_.find(*part.content) : parts_.end();
      return found == parts_.end() ? std::nullopt : std::optional(found->second);
    };
    ctx.part_sink = [this](const PartName& part, std::span<const std::byte> bytes) {
      const std::lock_guard<std::mutex> lock(mutex_);
      made_.insert(part.number);
      ASSERT_TRUE(part.content) << "part " << part.number;
      parts_[*part.content].assign(bytes.begin(), bytes.end());
    };
    return ctx;
  }

  void forget() { parts_.clear(); }

  [[nodiscard]] const std::vector<PartName>& names() const { return names_; }
  [[nodiscard]] std::size_t count() const { return names_.size(); }
  [[nodiscard]] const std::set<std::size_t>& made() const { return made_; }

 private:
  std::mutex mutex_;
  std::map<Digest, std::vector<std::byte>> parts_;
  std::vector<PartName> names_;
  std::set<std::size_t> made_;
};

}  // namespace sightline
