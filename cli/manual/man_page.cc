#include "cli/manual/man_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace cairn {
namespace {

// Escapes what roff would read as its own: backslashes, hyphens that should stay minus signs, and
// the letters that it prints as typographic ones.
std::string Escaped(std::string_view text) {
  std::string escaped;
  for (const char letter : text) {
    switch (letter) {
      case '\\':
        escaped += "\\e";
        break;
      case '-':
        escaped += "\\-";
        break;
      case '\'':
        escaped += "\\(aq";
        break;
      case '`':
        escaped += "\\(ga";
        break;
      case '^':
        escaped += "\\(ha";
        break;
      case '~':
        escaped += "\\(ti";
        break;
      case '"':
        escaped += "\\(dq";
        break;
      default:
        escaped += letter;
    }
  }
  return escaped;
}

// A line that begins with a dot would be a request.
std::string Line(const std::string& line) { return (line.starts_with('.') ? "\\&" : "") + line; }

// Breaks escaped text into short lines, because roff takes lines of any length, but its linters do
// not.
std::string Broken(std::string_view text) {
  constexpr size_t kMaxLine = 76;
  std::string filled, line;
  const auto end_line = [&] {
    if (!line.empty()) {
      filled += Line(line) + "\n";
    }
    line.clear();
  };
  while (!text.empty()) {
    const size_t begin = text.find_first_not_of(" \n");
    if (begin == std::string_view::npos) {
      break;
    }
    text.remove_prefix(begin);
    const std::string_view word = text.substr(0, text.find_first_of(" \n"));
    text.remove_prefix(word.size());
    if (line.size() + 1 + word.size() > kMaxLine) {
      end_line();
    }
    line += line.empty() ? "" : " ";
    line += word;
  }
  end_line();
  return filled;
}

std::string Filled(std::string_view text) { return Broken(Escaped(text)); }

std::string Sentence(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != ':') {
    text += '.';
  }
  return text;
}

std::string Bold(std::string_view text) { return "\\fB" + Escaped(text) + "\\fR"; }
std::string Italic(std::string_view text) { return "\\fI" + Escaped(text) + "\\fR"; }

std::string Title(const ArgumentRow& row) {
  if (row.is_positional) {
    return Italic(row.names.front());
  }
  std::vector<std::string> names;
  for (const std::string& name : row.names) {
    names.push_back(Bold(name));
  }
  const std::string value = row.value.empty() ? "" : " " + Italic(row.value);
  return fmt::format("{}{}", fmt::join(names, ", "), value);
}

std::string Entry(const ArgumentRow& row) {
  std::string meaning = Sentence(row.meaning);
  if (row.is_positional && !row.words.empty()) {
    meaning += fmt::format(" One of {}.", row.value);
  }
  if (!row.default_value.empty()) {
    meaning += fmt::format(" Default: {}.", row.default_value);
  }
  if (!row.needs.empty()) {
    meaning += fmt::format(" Only with {}.", fmt::join(row.needs, ", "));
  }
  if (row.is_required && !row.is_positional) {
    meaning += " Required.";
  }
  return ".TP\n" + Line(Title(row)) + "\n" + Filled(meaning);
}

std::string Entries(const char* title, const CommandTable& command, bool positional) {
  std::string entries;
  for (const ArgumentRow& row : command.arguments) {
    entries += row.is_positional == positional ? Entry(row) : "";
  }
  return entries.empty() ? "" : fmt::format(".SH {}\n{}", title, entries);
}

std::string Synopsis(const CommandTable& command, const std::string& full_name) {
  std::string synopsis = Bold(full_name) + " [" + Italic("OPTIONS") + "]";
  for (const ArgumentRow& row : command.arguments) {
    if (!row.is_positional && row.is_required) {
      synopsis += "\n" + Title(row);
    }
  }
  for (const ArgumentRow& row : command.arguments) {
    if (row.is_positional) {
      const std::string name = Title(row) + (row.is_repeated ? "..." : "");
      synopsis += "\n" + (row.is_required ? name : "[" + name + "]");
    }
  }
  if (!command.commands.empty()) {
    synopsis += "\n" + Italic("VERB");
  }
  return ".SH SYNOPSIS\n" + synopsis + "\n";
}

// The footer of --help is text, with commands in indented lines.
class Footer {
 public:
  explicit Footer(std::string_view footer) {
    while (!footer.empty()) {
      const std::string_view line = footer.substr(0, footer.find('\n'));
      footer.remove_prefix(std::min(line.size() + 1, footer.size()));
      Add(line);
    }
    EndParagraph();
    EndCode();
  }

  // What stands before the line that begins with "Example", and from there on.
  const std::string& notes() const { return parts_[0]; }
  const std::string& examples() const { return parts_[1]; }

 private:
  void Add(std::string_view line) {
    if (line.starts_with("Example")) {
      EndParagraph();
      EndCode();
      part_ = 1;
      const bool is_title = line == "Example:" || line == "Examples:";
      paragraph_ = is_title ? "" : std::string(line);
    } else if (line.starts_with("  ")) {
      EndParagraph();
      code_ += Line(Escaped(line.substr(2))) + "\n";
    } else if (line.empty()) {
      EndParagraph();
    } else {
      EndCode();
      paragraph_ += " " + std::string(line);
    }
  }

  void EndParagraph() {
    if (!paragraph_.empty()) {
      parts_[part_] += (parts_[part_].empty() && part_ == 1 ? "" : ".PP\n") + Filled(paragraph_);
    }
    paragraph_.clear();
  }

  void EndCode() {
    if (!code_.empty()) {
      parts_[part_] += (parts_[part_].empty() ? "" : ".PP\n") + (".EX\n" + code_) + ".EE\n";
    }
    code_.clear();
  }

  std::string parts_[2];
  int part_ = 0;
  std::string paragraph_, code_;
};

std::string Uppercase(std::string text) {
  for (char& letter : text) {
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  }
  return text;
}

struct Colophon {
  std::string program, version, date;
  std::string exit_codes;  // The footer of the program.
};

// The pages of `command`, whose words are "cairn keys" and whose file is "cairn-keys.1".
void AppendPages(const CommandTable& command, const std::string& words, const std::string& parent,
                 const Colophon& colophon, std::vector<ManPage>* pages) {
  std::string name = words;
  for (char& letter : name) {
    letter = letter == ' ' ? '-' : letter;
  }
  const bool is_program = parent.empty();
  const Footer footer(is_program ? "" : command.footer);
  std::string text = fmt::format(".TH {} 1 \"{}\" \"{} {}\" \"Cairn\"\n", Escaped(Uppercase(name)),
                                 colophon.date, colophon.program, colophon.version);
  text += ".SH NAME\n" + Broken(Escaped(name) + " \\- " + Escaped(command.meaning));
  text += Synopsis(command, words);
  text += ".SH DESCRIPTION\n" + Filled(Sentence(command.meaning)) + footer.notes();
  if (!command.commands.empty()) {
    text += ".SH VERBS\n";
    for (const CommandTable& below : command.commands) {
      text += ".TP\n" + Bold(words + " " + below.name) + "\n" + Filled(Sentence(below.meaning));
    }
  }
  text += Entries("ARGUMENTS", command, true) + Entries("OPTIONS", command, false);
  text += footer.examples().empty() ? "" : ".SH EXAMPLES\n" + footer.examples();
  text += ".SH EXIT STATUS\n" + Filled(colophon.exit_codes);
  text += ".SH SEE ALSO\n";
  std::vector<std::string> others;
  for (const CommandTable& below : command.commands) {
    others.push_back(fmt::format(".BR {}\\-{} (1)", Escaped(name), Escaped(below.name)));
  }
  if (!is_program) {
    others.insert(others.begin(), fmt::format(".BR {} (1)", Escaped(parent)));
  }
  text += fmt::format("{}\n", fmt::join(others, " ,\n"));
  pages->push_back({name + ".1", std::move(text)});
  for (const CommandTable& below : command.commands) {
    AppendPages(below, words + " " + below.name, name, colophon, pages);
  }
}

}  // namespace

std::vector<ManPage> MakeManPages(const CommandTable& program, const std::string& version,
                                  const std::string& date) {
  std::vector<ManPage> pages;
  AppendPages(program, program.name, "", {program.name, version, date, program.footer}, &pages);
  return pages;
}

}  // namespace cairn
