#include "lab/experiments/experiment_result.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/seconds_since.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kMaxResultBytes = uint64_t{1} << 24;

Json CellAsJson(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) {
    return *text;
  }
  const double value = std::get<double>(cell);
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Cell CellFromJson(const Json& json) {
  if (json.is_string()) {
    return json.get<std::string>();
  }
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json TableAsJson(const ResultTable& table) {
  Json json = {{"columns", Json::array()}, {"rows", Json::array()}};
  for (const Column& column : table.columns()) {
    json["columns"].push_back({{"name", column.name}, {"is_timing", column.is_timing}});
  }
  for (const std::vector<Cell>& row : table.rows()) {
    Json cells = Json::array();
    for (const Cell& cell : row) {
      cells.push_back(CellAsJson(cell));
    }
    json["rows"].push_back(std::move(cells));
  }
  return json;
}

ResultTable TableFromJson(const Json& json, const std::string& what) {
  std::vector<Column> columns;
  for (const Json& column : json.at("columns")) {
    columns.push_back({column.at("name"), column.at("is_timing")});
  }
  const size_t num_columns = columns.size();
  ResultTable table(std::move(columns));
  for (const Json& row : json.at("rows")) {
    if (!row.is_array() || row.size() != num_columns) {
      throw Error(ErrorCode::kBadInput, what + ": a row does not have one cell per column");
    }
    std::vector<Cell> cells;
    for (const Json& cell : row) {
      cells.push_back(CellFromJson(cell));
    }
    table.AddRow(std::move(cells));
  }
  return table;
}

}  // namespace

std::string ResultAsJson(const ExperimentResult& result) {
  Json parameters = Json::array();
  for (const auto& [name, value] : result.parameters) {
    parameters.push_back({name, value});
  }
  const Json json = {{"name", result.name},         {"size", ExperimentSizeName(result.size)},
                     {"seed", result.seed},         {"commit", result.commit},
                     {"seconds", result.seconds},   {"verdict", VerdictName(result.verdict)},
                     {"sentence", result.sentence}, {"parameters", std::move(parameters)},
                     {"figures", result.figures},   {"table", TableAsJson(result.table)}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

ExperimentResult ResultFromJson(const std::string& text, const std::string& what) {
  try {
    const Json json = Json::parse(text);
    ExperimentResult result;
    result.name = json.at("name");
    result.size = ExperimentSizeFromName(json.at("size"));
    result.seed = json.at("seed");
    result.commit = json.at("commit");
    result.seconds = json.at("seconds");
    result.verdict = VerdictFromName(json.at("verdict"));
    result.sentence = json.at("sentence");
    for (const Json& parameter : json.at("parameters")) {
      result.parameters.emplace_back(parameter.at(0), parameter.at(1));
    }
    result.figures = json.at("figures").get<std::vector<std::string>>();
    result.table = TableFromJson(json.at("table"), what);
    return result;
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kBadInput, what + ": " + error.what());
  }
}

ExperimentResult RunExperiment(const Experiment& experiment, const ExperimentContext& context,
                               const std::string& commit, const std::string& folder,
                               bool* figures_drawn) {
  const auto start = std::chrono::steady_clock::now();
  ExperimentOutcome outcome = experiment.run(context);
  ExperimentResult result;
  result.name = experiment.name;
  result.size = context.size;
  result.seed = context.seed;
  result.commit = commit;
  result.parameters = std::move(outcome.parameters);
  result.table = std::move(outcome.table);
  result.verdict = outcome.verdict;
  result.sentence = std::move(outcome.sentence);
  *figures_drawn = true;
  for (const Figure& figure : outcome.figures) {
    *figures_drawn = WriteFigure(figure, folder) && *figures_drawn;
    result.figures.push_back(figure.name);
  }
  result.seconds = SecondsSince(start);
  const std::filesystem::path path(folder);
  WriteTextFile((path / (result.name + ".csv")).string(), result.table.Csv());
  WriteTextFile((path / (result.name + ".json")).string(), ResultAsJson(result));
  return result;
}

std::vector<ExperimentResult> ReadResults(const std::string& folder,
                                          const std::vector<Experiment>& experiments) {
  std::vector<ExperimentResult> results;
  for (const Experiment& experiment : experiments) {
    const std::filesystem::path path = std::filesystem::path(folder) / (experiment.name + ".json");
    if (std::filesystem::exists(path)) {
      results.push_back(
          ResultFromJson(ReadTextFile(path.string(), kMaxResultBytes), path.string()));
    }
  }
  return results;
}

}  // namespace cairn
