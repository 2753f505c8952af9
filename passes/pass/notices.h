#pragma once

#include "formats/drive/notice.h"
#include "passes/pass/pass_context.h"

namespace sightline {

// The notice, after a warning of its text.
inline Notice warned(const PassContext& ctx, Notice notice) {
  ctx.warn(notice.text);
  return notice;
}

}  // namespace sightline
