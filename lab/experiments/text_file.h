// Reads and writes whole text files. Private to lab.
#ifndef CAIRN_LAB_EXPERIMENTS_TEXT_FILE_H_
#define CAIRN_LAB_EXPERIMENTS_TEXT_FILE_H_

#include <string>

namespace cairn {

// Replaces the file. Throws Error(kIo) that names the file.
void WriteTextFile(const std::string& path, const std::string& text);

// Throws Error(kNotFound) that names the file if it cannot be read.
std::string ReadTextFile(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_TEXT_FILE_H_
