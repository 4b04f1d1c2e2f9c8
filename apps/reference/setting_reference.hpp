#pragma once
#include "apps/reference/page.hpp"

namespace apps {

/// What `ardent help config` and `help sidecar` print of their tables of keys.
[[nodiscard]] Page config_page();
[[nodiscard]] Page sidecar_page();

}  // namespace apps
