#include "cli/usage_message.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "cli/manual/command_table.h"
#include "cli/options/nearest_name.h"
#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

std::vector<std::string> VerbNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CommandTable& command : TableOf(app).commands) {
    names.push_back(command.name);
  }
  return names;
}

std::vector<std::string> OptionNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const ArgumentRow& row : TableOf(app).arguments) {
    if (!row.is_positional) {
      names.insert(names.end(), row.names.begin(), row.names.end());
    }
  }
  return names;
}

// "there is no verb 'keys nwe'; did you mean 'new'?" `verb` is "keys", or empty for the program.
std::string NoSuchVerb(const CLI::App& app, const std::string& verb, const std::string& word) {
  return fmt::format("there is no verb '{}{}{}'{}", verb, verb.empty() ? "" : " ", Excerpt(word),
                     DidYouMean(word, VerbNames(app)));
}

// `apps` are those whose options the command line may have.
std::string NoSuchOption(const std::vector<const CLI::App*>& apps, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  std::vector<std::string> known;
  for (const CLI::App* app : apps) {
    const std::vector<std::string> names = OptionNames(*app);
    known.insert(known.end(), names.begin(), names.end());
  }
  return fmt::format("there is no option '{}'{}", Excerpt(name), DidYouMean(name, known));
}

bool HasVerb(const CLI::App& app, const std::string& name) {
  const auto verbs = app.get_subcommands([](const CLI::App*) { return true; });
  return std::any_of(verbs.begin(), verbs.end(),
                     [&](const CLI::App* verb) { return verb->get_name() == name; });
}

// What is wrong before the first verb: a word that is neither a global option nor a verb. Empty if
// nothing is.
std::string FirstUnknown(const CLI::App& app, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("-")) {
      return HasVerb(app, word) ? "" : NoSuchVerb(app, "", word);
    }
    const std::string name = word.substr(0, word.find('='));
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option == nullptr) {
      return NoSuchOption({&app}, name);
    }
    i += option->get_expected_min() > 0 && name == word ? 1 : 0;
  }
  return "";
}

// The verbs of the command line, from the outermost to the innermost.
std::vector<const CLI::App*> ParsedVerbs(const CLI::App& app) {
  std::vector<const CLI::App*> verbs;
  for (const CLI::App* verb = &app; !verb->get_subcommands().empty();) {
    verb = verb->get_subcommands().front();
    verbs.push_back(verb);
  }
  return verbs;
}

// What no verb and no option took, if that explains the error better than CLI11 does: it tells of
// what is missing before it tells of what is misspelled.
std::string Misspelled(const CLI::App& app, const std::vector<const CLI::App*>& verbs,
                       const std::string& path) {
  const std::vector<std::string> rest = app.remaining(true);
  const auto option = std::find_if(rest.begin(), rest.end(), [](const std::string& word) {
    return word.size() > 1 && word.front() == '-' && word != "--";
  });
  if (option != rest.end()) {
    std::vector<const CLI::App*> apps = verbs;
    apps.push_back(&app);
    return NoSuchOption(apps, *option);
  }
  if (!rest.empty() && !VerbNames(*verbs.back()).empty()) {
    return NoSuchVerb(*verbs.back(), path, rest.front());
  }
  return "";
}

}  // namespace

std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  constexpr size_t kMaxBytes = 500;
  const std::vector<const CLI::App*> verbs = ParsedVerbs(app);
  std::string path;
  for (const CLI::App* verb : verbs) {
    path += (path.empty() ? "" : " ") + verb->get_name();
  }
  std::string misspelled = FirstUnknown(app, argc, argv);
  if (misspelled.empty() && !verbs.empty()) {
    misspelled = Misspelled(app, verbs, path);
  }
  return fmt::format("{}\nRun '{}{}{} --help' for help.",
                     misspelled.empty() ? Excerpt(error.what(), kMaxBytes) : misspelled,
                     app.get_name(), path.empty() ? "" : " ", path);
}

const CLI::App& FindVerb(const CLI::App& app, const std::vector<std::string>& words) {
  const CLI::App* verb = &app;
  std::string path;
  for (const std::string& word : words) {
    const std::vector<std::string> names = VerbNames(*verb);
    if (std::find(names.begin(), names.end(), word) == names.end()) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}\nRun '{} --help' for a list.", NoSuchVerb(*verb, path, word),
                              app.get_name() + (path.empty() ? "" : " ") + path));
    }
    verb = verb->get_subcommand(word);
    path += (path.empty() ? "" : " ") + word;
  }
  return *verb;
}

}  // namespace cairn
