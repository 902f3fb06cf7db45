// Man pages of a program and of its verbs.
#ifndef CAIRN_CLI_MANUAL_MAN_PAGE_H_
#define CAIRN_CLI_MANUAL_MAN_PAGE_H_

#include <string>
#include <vector>

#include "cli/manual/command_table.h"

namespace cairn {

struct ManPage {
  std::string file_name;  // "cairn-keys-new.1".
  std::string text;       // roff with the macros of man(7); ASCII.
};

// The page of the program, then one for each verb and each verb below it. `version` is "0.1.0" and
// `date` "2026-11-26", or empty if it is unknown.
std::vector<ManPage> MakeManPages(const CommandTable& program, const std::string& version,
                                  const std::string& date);

}  // namespace cairn

#endif  // CAIRN_CLI_MANUAL_MAN_PAGE_H_
