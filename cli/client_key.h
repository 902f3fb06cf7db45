// The API key that clients send to a server.
#ifndef CAIRN_CLI_CLIENT_KEY_H_
#define CAIRN_CLI_CLIENT_KEY_H_

#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace cairn {

struct ClientKeyArguments {
  std::string file;
  bool allow_plain = false;  // As BoundedClientOptions::allow_plain_key.

  // Returns the key: the word in the file, else that of the environment variable CAIRN_API_KEY,
  // else nothing. Throws as ReadTextFile, and Error(kBadInput), which names the file, if the file
  // does not hold exactly one word.
  std::string Read() const;
};

// Adds --api-key-file and --insecure-key for clients of `server`, the option of a URL. Refuses
// --api-key: everybody on the machine can read command lines.
void AddClientKeyOptions(CLI::App* command, CLI::Option* server, ClientKeyArguments* key);

// Refuses --api-key as above, for a verb that takes no key.
void RefuseKeyOnCommandLine(CLI::App* command, const std::string& instead);

}  // namespace cairn

#endif  // CAIRN_CLI_CLIENT_KEY_H_
