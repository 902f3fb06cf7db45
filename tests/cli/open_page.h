// Opens the page /ui of a server in a browser.
#ifndef CAIRN_TESTS_CLI_OPEN_PAGE_H_
#define CAIRN_TESTS_CLI_OPEN_PAGE_H_

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "support/temp_dir.h"

namespace cairn::testing {

// Empty, or why there is no browser to open the page with.
std::string WhyNoBrowser();

// Does in Chromium what `todo` says and returns what was seen; tests/cli/ui_page/open_page.py
// describes both.
nlohmann::json OpenPage(const nlohmann::json& todo, const TempDir& dir);

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_CLI_OPEN_PAGE_H_
