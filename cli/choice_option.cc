#include "cli/choice_option.h"

#include <CLI/CLI.hpp>

namespace cairn {

void AddChoiceOption(CLI::App* command, const std::string& flag, NamedChoice choice,
                     const std::string& description) {
  command
      ->add_option_function<std::string>(
          flag, [choice](const std::string& name) mutable { choice.Set(name); }, description)
      ->check(CLI::IsMember(choice.names()))
      ->type_name("KIND")
      ->default_str(choice.Get());
}

}  // namespace cairn
