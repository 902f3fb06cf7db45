// What a binary was built from. Only programs link it: whatever links it is linked again after each
// commit.
#ifndef CAIRN_CLI_BUILD_INFO_H_
#define CAIRN_CLI_BUILD_INFO_H_

namespace cairn {

const char* BuildVersion();    // "0.1.0".
const char* BuildCommit();     // "0daf9f0f12", "0daf9f0f12-dirty"; empty if it is unknown.
const char* BuildDate();       // Of the commit, "2026-11-26"; empty if it is unknown.
const char* BuildCompiler();   // "GNU 12.2.0, Release, x86_64".
const char* BuildLibraries();  // "Ceres 2.1.0, Eigen 3.4.0, ...": those that it was built with.

}  // namespace cairn

#endif  // CAIRN_CLI_BUILD_INFO_H_
