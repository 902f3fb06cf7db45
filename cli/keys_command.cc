// `cairn keys`: the API keys of a server.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/arguments.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/printable.h"
#include "http/keys/key_file.h"

namespace cairn {
namespace {

struct KeyArguments {
  std::string path;
  ApiKey key;
  std::string may = "localize";
  bool json = false;
};

KeyRights ParseRights(const std::string& text) {
  KeyRights rights;
  std::string_view rest = text;
  while (true) {
    const size_t comma = rest.find(',');
    const std::optional<KeyRight> right = KeyRightFromName(rest.substr(0, comma));
    if (!right) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("--may: '{}' is neither localize, look nor copy",
                              Excerpt(rest.substr(0, comma))));
    }
    rights = rights | *right;
    if (comma == std::string_view::npos) {
      return rights;
    }
    rest.remove_prefix(comma + 1);
  }
}

auto WithLabel(const std::string& label) {
  return [&label](const ApiKey& key) { return key.label == label; };
}

ExitCode RunNewKey(const KeyArguments& arguments) {
  ApiKey key = arguments.key;
  key.may = ParseRights(arguments.may);
  key.Validate();
  const std::string secret = NewSecret();
  key.hash = HashOfSecret(secret);
  ChangeKeyFile(arguments.path, [&](std::vector<ApiKey>* keys) {
    if (std::any_of(keys->begin(), keys->end(), WithLabel(key.label))) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{} has a key '{}' already; remove it first, or choose another label",
                              arguments.path, key.label));
    }
    if (keys->size() == kMaxKeys) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{} has {} keys, as many as it may have", arguments.path, kMaxKeys));
    }
    keys->push_back(key);
  });
  fmt::print("{}\n", secret);
  fmt::print(stderr,
             "This is the only time that the key '{}' is shown: {} holds its hash. A running "
             "server reads the file after SIGHUP.\n",
             key.label, arguments.path);
  return ExitCode::kOk;
}

void PrintKeysAsJson(const std::vector<ApiKey>& keys) {
  using Json = nlohmann::ordered_json;
  const auto or_null = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  Json json = Json::array();
  for (const ApiKey& key : keys) {
    json.push_back({{"label", key.label},
                    {"ratePerS", or_null(key.rate_per_s)},
                    {"burst", key.rate_per_s ? Json(key.Burst()) : Json(nullptr)},
                    {"quotaPerDay", or_null(key.quota_per_day)},
                    {"may", NamesOf(key.may, ",")}});
  }
  PrintJson(json);
}

ExitCode RunListKeys(const KeyArguments& arguments) {
  const std::vector<ApiKey> keys = ReadKeyFile(arguments.path);
  if (arguments.json) {
    PrintKeysAsJson(keys);
    return ExitCode::kOk;
  }
  size_t width = 5;
  for (const ApiKey& key : keys) {
    width = std::max(width, key.label.size());
  }
  const auto or_dash = [](const auto& value) { return value ? fmt::format("{}", *value) : "-"; };
  fmt::print("{:<{}}  {:>8}  {:>7}  {:>12}  may\n", "label", width, "rate/s", "burst", "quota/day");
  for (const ApiKey& key : keys) {
    fmt::print("{:<{}}  {:>8}  {:>7}  {:>12}  {}\n", key.label, width, or_dash(key.rate_per_s),
               key.rate_per_s ? fmt::format("{}", key.Burst()) : "-", or_dash(key.quota_per_day),
               NamesOf(key.may, ","));
  }
  return ExitCode::kOk;
}

ExitCode RunRemoveKey(const KeyArguments& arguments) {
  ReadKeyFile(arguments.path);  // A missing file is no file to remove a key from.
  ChangeKeyFile(arguments.path, [&](std::vector<ApiKey>* keys) {
    if (std::erase_if(*keys, WithLabel(arguments.key.label)) == 0) {
      throw Error(ErrorCode::kNotFound,
                  fmt::format("{} has no key '{}'", arguments.path, Excerpt(arguments.key.label)));
    }
  });
  fmt::print(stderr, "A running server refuses the key '{}' after SIGHUP.\n", arguments.key.label);
  return ExitCode::kOk;
}

void AddFile(CLI::App* command, KeyArguments* arguments) {
  command->add_option("FILE", arguments->path, "The file of keys that --api-keys of serve names")
      ->required();
}

void AddLabel(CLI::App* command, KeyArguments* arguments, const char* description) {
  command->add_option("--label", arguments->key.label, description)->required()->type_name("NAME");
}

void AddNew(CLI::App* keys, Shell* shell, const std::shared_ptr<KeyArguments>& arguments) {
  CLI::App* command = keys->add_subcommand("new", "Add a key and print it, once");
  AddFile(command, arguments.get());
  AddLabel(command, arguments.get(),
           "Whose key it is; appears in metrics and in the access log. Letters, digits, . _ -");
  command
      ->add_option("--may", arguments->may,
                   "What it may do: localize (queries), look (coverage, tiles, versions, /ui, "
                   "health, metrics), copy (payloads of tiles)")
      ->type_name("RIGHT,...")
      ->capture_default_str();
  CLI::Option* rate = command
                          ->add_option("--rate", arguments->key.rate_per_s,
                                       "Requests a second, on average. Default: no limit")
                          ->check(NumberWithin(1e-3, 1e6))
                          ->type_name("N");
  command
      ->add_option("--burst", arguments->key.burst,
                   "Requests at once after a pause. Default: those of a second")
      ->needs(rate)
      ->type_name("N");
  command
      ->add_option("--quota", arguments->key.quota_per_day,
                   "Requests a day, from midnight to midnight UTC. Default: no limit")
      ->type_name("N");
  command->footer(
      "Example, whose file only its owner can read:\n"
      "  (umask 077 && cairn keys new keys.json --label acme-app --rate 5 --quota 100000 > "
      "acme.key)");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunNewKey(*arguments); }; });
}

}  // namespace

void AddKeysCommand(CLI::App* app, Shell* shell) {
  CLI::App* keys = app->add_subcommand("keys", "Make, list and remove API keys of a server");
  keys->require_subcommand(1);
  const auto arguments = std::make_shared<KeyArguments>();
  AddNew(keys, shell, arguments);
  CLI::App* list =
      keys->add_subcommand("list", "List the labels of the keys, and what they may do");
  AddFile(list, arguments.get());
  AddJsonFlag(list, &arguments->json);
  list->footer("Example:\n  cairn keys list keys.json");
  list->callback(
      [shell, arguments] { shell->run = [arguments] { return RunListKeys(*arguments); }; });
  CLI::App* remove = keys->add_subcommand("remove", "Remove a key");
  AddFile(remove, arguments.get());
  AddLabel(remove, arguments.get(), "The key to remove");
  remove->footer("Example:\n  cairn keys remove keys.json --label acme-app");
  remove->callback(
      [shell, arguments] { shell->run = [arguments] { return RunRemoveKey(*arguments); }; });
  keys->footer(
      "The file holds hashes of the keys, no keys. 'cairn serve --api-keys FILE' reads it at its\n"
      "start and after SIGHUP.\n"
      "Example:\n  cairn keys new keys.json --label acme-app --rate 5");
}

}  // namespace cairn
