// SPDX-License-Identifier: MIT
/// @file
/// @brief Reader of the Common Layer Interface (CLI), text and binary, with the dialects that machine software writes.
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <istream>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "slice2mesh/cli/cli_limits.hpp"
#include "slice2mesh/core/diagnostics.hpp"
#include "slice2mesh/core/error.hpp"
#include "slice2mesh/core/listening_sort.hpp"
#include "slice2mesh/core/progress.hpp"
#include "slice2mesh/core/slice_stack.hpp"

namespace slice2mesh {

/// What decides whether a closed contour is an outer boundary or a hole.
enum class CliOrientation : std::uint8_t {
  Auto,     ///< Dir, but Nesting for a file in which all contours are holes (a writer that gives dir 0 to everything)
  Dir,      ///< the file's `dir`; points in the other order are reversed
  Winding,  ///< the order of the points; `dir` is corrected
  Nesting   ///< how many contours of the same part and layer lie around it; `dir` and order are corrected
};

/// Whether an open line (dir 2) that ends where it began is a closed contour.
enum class CliCloseLines : std::uint8_t {
  Auto,   ///< yes if the file has CLI+ parameters, or if it has no other polylines
  Never,  ///< it stays an open line
  Always  ///< it becomes a contour, outer or hole by nesting
};

/// What the numbers of `$$LAYER` count.
enum class CliZUnit : std::uint8_t {
  Auto,        ///< units, unless `$$DIMENSION` or the thickness say that z is in mm
  Units,       ///< the file's units, as described
  Millimeters  ///< mm, whatever `$$UNITS` says
};

/// How the 16-bit coordinates of short binary commands are read.
enum class CliShortCoordinates : std::uint8_t {
  Auto,      ///< signed if `$$DIMENSION` has a negative minimum or fits only after wrapping
  Unsigned,  ///< 0 to 65535, as described
  Signed     ///< -32768 to 32767
};

/// How a CLI file is read.
struct CliReadOptions {
  /// Outer boundary or hole.
  CliOrientation orientation = CliOrientation::Auto;
  /// Open line or contour.
  CliCloseLines close_lines = CliCloseLines::Auto;
  /// What heights count.
  CliZUnit z_unit = CliZUnit::Auto;
  /// Signed or not.
  CliShortCoordinates short_coordinates = CliShortCoordinates::Auto;
  double unit = 0;  ///< mm per unit, in [1e-9, 1e6]; used instead of the file's `$$UNITS` if > 0
  /// Called now and then; what it throws ends the reading and goes on to the caller.
  std::function<void()> poll;

  /// Options that take a file by its word: no dialect is guessed. What `write_cli` wrote is read back like this.
  [[nodiscard]] static CliReadOptions as_written() {
    CliReadOptions options;
    options.orientation = CliOrientation::Dir;
    options.close_lines = CliCloseLines::Never;
    options.z_unit = CliZUnit::Units;
    return options;
  }
};

namespace detail {

/// Layer thickness that a printer may have, mm: a micron to a centimeter.
inline constexpr double kCliThinnestLayer = 1e-3;
inline constexpr double kCliThickestLayer = 10;
/// Comparisons that the nesting of one layer may cost per point of the layer, and in any case. Beyond, the contours
/// that are left are oriented by winding, so that the time stays proportional to the input.
inline constexpr std::uint64_t kCliNestingWorkPerPoint = 2000;
inline constexpr std::uint64_t kCliNestingWork = 10'000'000;

/// Findings of one kind, counted, with the first place.
struct CliTally {
  std::uint64_t count = 0;
  std::int64_t layer = -1;
  std::int64_t polyline = -1;
  void add(std::int64_t at_layer = -1, std::int64_t at_polyline = -1, std::uint64_t n = 1) {
    if (n == 0) return;
    if (count == 0) {
      layer = at_layer;
      polyline = at_polyline;
    }
    count += n;
  }
  void report(Diagnostics* diagnostics, Severity severity, const char* code, const std::string& message) const {
    if (diagnostics != nullptr && count > 0)
      diagnostics->add(severity, Stage::Read, code, message, layer, polyline, count);
  }
};

/// The sign of the area of a closed polygon: 1 counter-clockwise, -1 clockwise, 0 if rounding could decide it.
/// Linear in the number of points.
inline int winding_sign(const std::vector<Point2>& points) {
  if (points.size() < 3) return 0;
  const Point2 base = points.front();
  double sum = 0;
  double size = 0;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const double a = (points[i].x - base.x) * (points[i + 1].y - base.y);
    const double b = (points[i].y - base.y) * (points[i + 1].x - base.x);
    sum += a - b;
    size += std::abs(a) + std::abs(b);
  }
  // Forward error of the sum above: each term carries a few roundings, and adding n terms n more.
  const double bound = (static_cast<double>(points.size()) + 8) * std::numeric_limits<double>::epsilon() * size;
  if (sum > bound) return 1;
  if (sum < -bound) return -1;
  return 0;
}

/// Reverse a closed polygon; its first point stays the first.
inline void reverse_loop(std::vector<Point2>& points) {
  if (points.size() > 2) std::reverse(points.begin() + 1, points.end());
}

/// For each loop of one part in one layer: is it inside an odd number of the others? A loop's lowest (then leftmost)
/// vertex decides, by the parity of the edges crossed on the way to the left; no edge of the loop itself is among
/// them. Returns no value for loops that the work limit left undecided. `listen` is told what is looked at.
inline std::vector<std::optional<bool>> nesting_parity(const std::vector<const std::vector<Point2>*>& loops,
                                                       Poll& listen) {
  struct Edge {
    double y_low, y_high, x_low, x_high;  // x_low belongs to y_low
  };
  struct Query {
    Point2 point;
    std::size_t loop;
  };
  std::vector<std::optional<bool>> inside(loops.size());
  std::vector<Edge> edges;
  std::vector<Query> queries;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const std::vector<Point2>& points = *loops[l];
    if (points.empty()) continue;
    listen(points.size());
    Point2 lowest = points.front();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point2& a = points[i];
      const Point2& b = points[i + 1 == points.size() ? 0 : i + 1];
      if (a.y < b.y) edges.push_back({a.y, b.y, a.x, b.x});
      if (b.y < a.y) edges.push_back({b.y, a.y, b.x, a.x});
      if (a.y < lowest.y || (a.y == lowest.y && a.x < lowest.x)) lowest = a;
    }
    queries.push_back({lowest, l});
  }
  sort_listening(edges.begin(), edges.end(), listen, [](const Edge& a, const Edge& b) { return a.y_low < b.y_low; });
  sort_listening(queries.begin(), queries.end(), listen,
                 [](const Query& a, const Query& b) { return a.point.y < b.point.y; });
  std::uint64_t work = kCliNestingWork + kCliNestingWorkPerPoint * edges.size();
  std::vector<std::size_t> active;
  std::size_t next = 0;
  for (const Query& query : queries) {
    while (next < edges.size() && edges[next].y_low <= query.point.y) active.push_back(next++);
    if (active.size() > work) break;
    work -= active.size();
    listen(active.size() + 1);
    bool odd = false;
    for (std::size_t i = 0; i < active.size();) {
      const Edge& e = edges[active[i]];
      if (e.y_high <= query.point.y) {  // below for good: queries come with ascending y
        active[i] = active.back();
        active.pop_back();
        continue;
      }
      if (std::min(e.x_low, e.x_high) < query.point.x) {
        const double t = (query.point.y - e.y_low) / (e.y_high - e.y_low);
        const double x = t == 0 ? e.x_low : e.x_low + t * (e.x_high - e.x_low);
        if (x < query.point.x) odd = !odd;
      }
      ++i;
    }
    inside[query.loop] = odd;
  }
  return inside;
}

/// The parser: one object per call.
class CliParser {
public:
  CliParser(std::string_view bytes, const CliReadOptions& options, Diagnostics* diagnostics, std::string source)
      : bytes_(bytes), options_(options), diagnostics_(diagnostics), source_(std::move(source)),
        listen_(options_.poll, kPollEvery) {}
  CliParser(const CliParser&) = delete;
  CliParser& operator=(const CliParser&) = delete;

  SliceStack parse() {
    if (options_.unit != 0 && !(options_.unit >= kCliSmallestUnit && options_.unit <= kCliLargestUnit))
      throw OptionError("unit", "must be 0 or in [1e-9, 1e6] mm");
    parse_header();
    limit_ = kCliLargestCoordinate / stack_.unit;
    // z may turn out to be in mm, so that a file with large units and z in mm or the reverse is judged later.
    z_limit_ = kCliLargestCoordinate / std::min(stack_.unit, 1.0);
    if (binary_)
      parse_binary();
    else
      parse_text();
    resolve_shorts();
    order_layers();
    resolve_z_unit();
    clean_polylines();
    orient();
    report();
    stack_.source = source_;
    return std::move(stack_);
  }

private:
  // ---- errors and findings

  [[noreturn]] void fail(std::size_t byte, const std::string& message) const {
    byte = std::min(byte, bytes_.size());
    std::uint64_t line = 0;
    if (byte <= text_end_)
      line = 1 + static_cast<std::uint64_t>(
                     std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(byte), '\n'));
    throw ParseError(source_, byte, line, message);
  }

  void note(Severity severity, const char* code, const std::string& message) const {
    if (diagnostics_ != nullptr) diagnostics_->add(severity, Stage::Read, code, message);
  }

  // ---- text: characters, comments, commands

  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v'; }
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }
  static bool is_word(char c) { return is_digit(c) || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_'; }
  [[nodiscard]] bool at_end() const { return pos_ >= bytes_.size(); }
  [[nodiscard]] bool at(std::string_view text) const { return bytes_.compare(pos_, text.size(), text) == 0; }

  /// Skip a comment that starts at pos_: up to the next `//`. If a command stands in between, the comment was not
  /// closed and ends with its line.
  void skip_comment() {
    const std::size_t begin = pos_ + 2;
    const std::size_t close = bytes_.find("//", begin);
    const std::size_t line = bytes_.substr(0, close).find('\n', begin);
    if (close != std::string_view::npos &&
        (line == std::string_view::npos || bytes_.substr(0, close).find("$$", line) == std::string_view::npos)) {
      pos_ = close + 2;
      return;
    }
    unclosed_comments_.add();
    pos_ = line == std::string_view::npos ? bytes_.size() : line;
  }

  void skip_blanks() {
    while (!at_end()) {
      if (is_blank(bytes_[pos_]))
        ++pos_;
      else if (at("//"))
        skip_comment();
      else
        return;
    }
  }

  /// Is this the end of a command's arguments?
  [[nodiscard]] bool arguments_end() const { return at_end() || at("$$"); }

  /// Skip what is left of a command, up to the next `$$`.
  void skip_arguments() {
    while (!arguments_end()) {
      if (at("//")) {
        skip_comment();
      } else {
        const std::size_t next = bytes_.find_first_of("$/", pos_ + 1);
        pos_ = next == std::string_view::npos ? bytes_.size() : next;
      }
    }
  }

  struct Command {
    std::string_view keyword;
    std::size_t byte = 0;
  };

  /// The next `$$KEYWORD`; pos_ is then at the first character of its arguments. Empty at the end of the file.
  std::optional<Command> next_command() {
    listen_();
    skip_blanks();
    if (!arguments_end()) {
      stray_.add();
      skip_arguments();
    }
    if (at_end()) return std::nullopt;
    Command command;
    command.byte = pos_;
    pos_ += 2;
    std::size_t end = pos_;
    while (end < bytes_.size() && is_word(bytes_[end])) ++end;
    command.keyword = bytes_.substr(pos_, end - pos_);
    constexpr std::string_view kHeaderEnd = "HEADEREND";
    if (in_header_ && command.keyword.substr(0, kHeaderEnd.size()) == kHeaderEnd) {
      command.keyword = kHeaderEnd;  // binary data may follow at once
      pos_ += kHeaderEnd.size();
      return command;
    }
    pos_ = end;
    while (!at_end() && (bytes_[pos_] == ' ' || bytes_[pos_] == '\t')) ++pos_;
    if (!at_end() && bytes_[pos_] == '/' && !at("//")) ++pos_;
    return command;
  }

  /// A number at pos_, or none. Never NaN or infinite.
  std::optional<double> number() {
    const char* first = bytes_.data() + pos_;
    const char* const last = bytes_.data() + bytes_.size();
    const char* start = first;
    if (start != last && *start == '+') ++start;
    const char* digits = start;
    if (digits != last && *digits == '-' && start == first) ++digits;
    if (digits == last || !(is_digit(*digits) || *digits == '.')) return std::nullopt;
    double value = 0;
    const auto [end, code] = std::from_chars(start, last, value);
    if (code != std::errc() || !std::isfinite(value)) return std::nullopt;
    pos_ += static_cast<std::size_t>(end - first);
    return value;
  }

  /// A number that must be there. `what` says what it is.
  double expect_number(const char* what) {
    skip_blanks();
    if (arguments_end()) fail(pos_, std::string(what) + " is missing");
    const std::size_t begin = pos_;
    if (const std::optional<double> value = number()) return *value;
    fail(begin, std::string(what) + " is not a finite number");
  }

  double expect_integer(const char* what, double low, double high) {
    skip_blanks();
    const std::size_t begin = pos_;
    const double value = expect_number(what);
    if (value != std::floor(value)) fail(begin, std::string(what) + " is not an integer");
    if (value < low || value > high) fail(begin, std::string(what) + " is out of range");
    return value;
  }

  /// After a number: a comma, blanks, or the end of the arguments. Returns false at the end.
  bool next_field() {
    listen_();
    skip_blanks();
    if (arguments_end()) return false;
    if (bytes_[pos_] == ',') {
      ++pos_;
      skip_blanks();
      return !arguments_end();
    }
    return true;
  }

  /// After the last argument.
  void expect_end(const char* keyword) {
    skip_blanks();
    if (!at_end() && bytes_[pos_] == ',') ++pos_;
    skip_blanks();
    if (!arguments_end()) fail(pos_, std::string("unexpected text behind the arguments of $$") + keyword);
  }

  /// The rest of the line, without comments and blanks at its ends.
  std::string rest_of_line() {
    std::size_t end = pos_;
    while (end < bytes_.size() && bytes_[end] != '\n' && bytes_[end] != '\r' && bytes_.compare(end, 2, "$$") != 0 &&
           bytes_.compare(end, 2, "//") != 0)
      ++end;
    std::size_t begin = pos_;
    pos_ = end;
    while (begin < end && is_blank(bytes_[begin])) ++begin;
    while (end > begin && is_blank(bytes_[end - 1])) --end;
    return std::string(bytes_.substr(begin, end - begin));
  }

  // ---- header

  /// Note that a header keyword came again.
  void repeated(std::string_view keyword) {
    note(Severity::Repair, "header_keyword_repeated",
         "$$" + std::string(keyword) + " stands more than once; all agree or the first one counts");
  }

  void unreadable(const Command& command) {
    note(Severity::Warning, "header_value_unreadable",
         "the value of $$" + std::string(command.keyword) + " at byte " + std::to_string(command.byte) +
             " cannot be read and is ignored");
    skip_arguments();
  }

  /// An integer of the header that nothing depends on.
  template <class Integer>
  void optional_integer(const Command& command, std::optional<Integer>& target) {
    skip_blanks();
    const std::optional<double> value = number();
    skip_blanks();
    if (!value || *value != std::floor(*value) ||
        std::abs(*value) > static_cast<double>(std::numeric_limits<int>::max()) || !arguments_end()) {
      unreadable(command);
      return;
    }
    if (target)
      repeated(command.keyword);
    else
      target = static_cast<Integer>(*value);
  }

  void header_units(const Command& command) {
    skip_blanks();
    const std::size_t begin = pos_;
    const double value = expect_number("the value of $$UNITS");
    expect_end("UNITS");
    if (!(value >= kCliSmallestUnit && value <= kCliLargestUnit))
      fail(begin, "$$UNITS must be a number of mm in [1e-9, 1e6]");
    if (units_ && *units_ != value) fail(command.byte, "$$UNITS stands twice, with different values");
    if (units_) repeated(command.keyword);
    units_ = value;
  }

  void header_dimension(const Command& command) {
    std::array<double, 6> values{};
    std::size_t n = 0;
    for (;;) {
      skip_blanks();
      if (arguments_end()) break;
      if (bytes_[pos_] == ',') {  // extra commas are seen
        ++pos_;
        continue;
      }
      const std::optional<double> value = number();
      if (!value) {
        unreadable(command);
        return;
      }
      if (n < values.size()) values[n] = *value;
      ++n;
    }
    if (n < values.size()) {
      unreadable(command);
    } else if (stack_.dimension) {
      repeated(command.keyword);
    } else {
      stack_.dimension = values;
    }
  }

  void header_label(const Command& command) {
    skip_blanks();
    const std::optional<double> id = number();
    if (!id || *id != std::floor(*id) ||
        std::abs(*id) > static_cast<double>(std::numeric_limits<std::int32_t>::max())) {
      unreadable(command);
      return;
    }
    while (!at_end() && (bytes_[pos_] == ' ' || bytes_[pos_] == '\t')) ++pos_;
    if (!at_end() && bytes_[pos_] == ',') ++pos_;
    std::string text = rest_of_line();
    if (!stack_.labels.emplace(static_cast<std::int32_t>(*id), std::move(text)).second) repeated(command.keyword);
  }

  /// `$$USERDATA/uid,len,data`: len bytes, whatever they are.
  void header_userdata(const Command& command) {
    const std::size_t stop = bytes_.find_first_of(",\n$", pos_);
    if (stop == std::string_view::npos || bytes_[stop] != ',') fail(command.byte, "$$USERDATA has no length");
    pos_ = stop + 1;
    const double length =
        expect_integer("the length of $$USERDATA", 0, static_cast<double>(std::numeric_limits<std::int32_t>::max()));
    while (!at_end() && (bytes_[pos_] == ' ' || bytes_[pos_] == '\t')) ++pos_;
    if (!at_end() && bytes_[pos_] == ',')
      ++pos_;
    else if (length > 0)
      fail(pos_, "$$USERDATA has no data");
    if (length > static_cast<double>(bytes_.size() - pos_))
      fail(command.byte, "$$USERDATA announces more bytes than the file has");
    pos_ += static_cast<std::size_t>(length);
    note(Severity::Note, "userdata_skipped", "vendor data ($$USERDATA) is not kept");
  }

  void encoding(const Command& command, bool binary) {
    if (encoding_ && *encoding_ != binary) fail(command.byte, "the header says both $$BINARY and $$ASCII");
    if (encoding_) repeated(command.keyword);
    encoding_ = binary;
  }

  /// Returns false for a keyword that is not one of the header.
  bool header_keyword(const Command& command) {
    const std::string_view k = command.keyword;
    if (k == "UNITS")
      header_units(command);
    else if (k == "BINARY")
      encoding(command, true);
    else if (k == "ASCII")
      encoding(command, false);
    else if (k == "VERSION")
      optional_integer(command, stack_.version);
    else if (k == "DATE")
      optional_integer(command, stack_.date);
    else if (k == "LAYERS")
      optional_integer(command, announced_layers_);
    else if (k == "DIMENSION")
      header_dimension(command);
    else if (k == "LABEL")
      header_label(command);
    else if (k == "USERDATA")
      header_userdata(command);
    else if (k == "ALIGN")
      align_ = true;
    else if (k == "HEADERSTART")
      repeated(k);
    else
      return false;
    return true;
  }

  void parse_header() {
    text_end_ = bytes_.size();
    pos_ = bytes_.find("$$HEADERSTART");
    if (pos_ == std::string_view::npos) {
      fail(0, bytes_.empty() ? "the file is empty" : "no $$HEADERSTART: not a CLI file");
    }
    pos_ += std::string_view("$$HEADERSTART").size();
    in_header_ = true;
    while (in_header_) {
      const std::optional<Command> command = next_command();
      if (!command) fail(bytes_.size(), "the file ends before $$HEADEREND");
      const std::string_view k = command->keyword;
      if (k == "HEADEREND") {
        in_header_ = false;
      } else if (k == "GEOMETRYSTART") {
        if (encoding_ && *encoding_) fail(command->byte, "$$GEOMETRYSTART before $$HEADEREND");
        note(Severity::Repair, "header_end_missing", "$$HEADEREND is missing; the header ends at $$GEOMETRYSTART");
        pos_ = command->byte;
        in_header_ = false;
      } else if (k == "LAYER" || k == "POLYLINE" || k == "HATCHES" || k == "GEOMETRYEND") {
        fail(command->byte, "$$" + std::string(k) + " inside the header");
      } else if (!header_keyword(*command)) {
        unknown(k);
      }
    }
    if (!encoding_) {
      const std::size_t start = pos_;
      skip_blanks();
      if (!at("$$GEOMETRYSTART")) fail(start, "the header says neither $$BINARY nor $$ASCII");
      note(Severity::Repair, "encoding_missing", "the header says neither $$BINARY nor $$ASCII; the geometry is text");
      encoding_ = false;
    }
    binary_ = *encoding_;
    if (options_.unit > 0) {
      stack_.unit = options_.unit;
    } else if (units_) {
      stack_.unit = *units_;
    } else {
      fail(pos_, "the header has no $$UNITS (the option `unit` can say it)");
    }
  }

  void unknown(std::string_view keyword) {
    if (keyword.empty()) {
      stray_.add();
    } else {
      const std::size_t longest = 40;  // enough to recognize it
      ++unknown_[std::string(keyword.substr(0, longest))];
    }
    skip_arguments();
  }

  // ---- text geometry

  void add_layer(std::size_t byte, double z, bool is_short) {
    if (std::abs(z) > z_limit_) fail(byte, "the z of a layer is out of range (1e6 mm)");
    if (is_short) short_layers_.push_back(stack_.layers.size());
    stack_.layers.emplace_back();
    stack_.layers.back().z = z;
    layer_bytes_.push_back(byte);
  }

  Layer& current_layer(std::size_t byte, const char* keyword) {
    if (stack_.layers.empty()) fail(byte, std::string(keyword) + " before the first layer");
    return stack_.layers.back();
  }

  [[nodiscard]] std::int64_t layer_index() const { return static_cast<std::int64_t>(stack_.layers.size()) - 1; }

  void check_coordinate(std::size_t byte, double value) const {
    if (!(std::abs(value) <= limit_)) fail(byte, "a coordinate is out of range (1e6 mm) or not finite");
  }

  double coordinate() {
    skip_blanks();
    const std::size_t begin = pos_;
    const double value = expect_number("a coordinate");
    check_coordinate(begin, value);
    return value;
  }

  static constexpr double kInt32Low = -2147483648.0;
  static constexpr double kInt32High = 2147483647.0;
  static constexpr double kMostPoints = 4294967295.0;

  /// A number of points or hatches of at least `bytes_each` bytes; never more than the file can hold.
  std::size_t text_count(const char* what, double bytes_each) {
    skip_blanks();
    const std::size_t begin = pos_;
    const double n = expect_integer(what, 0, kMostPoints);
    if (n * bytes_each > static_cast<double>(bytes_.size() - pos_) + 1)
      fail(begin, std::string(what) + " is " + std::to_string(static_cast<std::uint64_t>(n)) +
                      ", more than the rest of the file can hold");
    return static_cast<std::size_t>(n);
  }

  void expect_field(const char* what) {
    if (!next_field()) fail(pos_, std::string(what) + " is missing");
  }

  void text_polyline(const Command& command) {
    Layer& layer = current_layer(command.byte, "$$POLYLINE");
    Polyline line;
    line.part = static_cast<std::int32_t>(expect_integer("the part id of a polyline", kInt32Low, kInt32High));
    expect_field("the direction of a polyline");
    line.direction = static_cast<Direction>(static_cast<int>(expect_integer("the direction of a polyline", 0, 2)));
    expect_field("the number of points of a polyline");
    const std::size_t n = text_count("the number of points of a polyline", 4);
    line.points.reserve(n);
    while (next_field()) {
      if (line.points.size() > n) fail(pos_, "the polyline has more points than it announces");
      Point2 p;
      p.x = coordinate();
      expect_field("the y of a point");
      p.y = coordinate();
      line.points.push_back(p);
    }
    if (line.points.size() == n + 1)
      point_count_.add(layer_index(), static_cast<std::int64_t>(layer.polylines.size()));
    else if (line.points.size() < n)
      fail(pos_,
           "the polyline announces " + std::to_string(n) + " points and has " + std::to_string(line.points.size()));
    line.process = process_;
    layer.polylines.push_back(std::move(line));
  }

  void text_hatches(const Command& command) {
    Layer& layer = current_layer(command.byte, "$$HATCHES");
    Hatches hatches;
    hatches.part = static_cast<std::int32_t>(expect_integer("the part id of hatches", kInt32Low, kInt32High));
    expect_field("the number of hatches");
    const std::size_t n = text_count("the number of hatches", 8);
    hatches.lines.reserve(n);
    while (next_field()) {
      if (hatches.lines.size() == n) fail(pos_, "there are more hatches than announced");
      std::array<double, 4> v{};
      for (std::size_t i = 0; i < v.size(); ++i) {
        if (i > 0) expect_field("a coordinate of a hatch");
        v[i] = coordinate();
      }
      hatches.lines.push_back({Point2{v[0], v[1]}, Point2{v[2], v[3]}});
    }
    if (hatches.lines.size() < n)
      fail(pos_,
           "there are " + std::to_string(hatches.lines.size()) + " hatches and " + std::to_string(n) + " announced");
    hatches.process = process_;
    layer.hatches.push_back(std::move(hatches));
  }

  /// The modal value that a CLI+ name stands for, or nothing.
  std::optional<double>* modal(std::string_view name) {
    std::string upper;
    for (const char c : name.substr(0, 16)) upper += static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    if (upper == "POWER") return &process_.power;
    if (upper == "SPEED") return &process_.speed;
    if (upper == "FOCUS") return &process_.focus;
    if (upper == "SPOTSIZE") return &process_.spot_size;
    return nullptr;
  }

  void text_modal(const Command& command, std::optional<double>& target) {
    has_parameters_ = true;
    target = expect_number("the value of a process parameter");
    expect_end(std::string(command.keyword).c_str());
  }

  /// `$$PARAM/name, type, value`.
  void text_param() {
    has_parameters_ = true;
    skip_blanks();
    const std::size_t comma = bytes_.find_first_of(",\n$", pos_);
    std::string_view name;
    if (comma != std::string_view::npos && bytes_[comma] == ',') {
      name = bytes_.substr(pos_, comma - pos_);
      while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
      pos_ = comma + 1;
      if (std::optional<double>* target = modal(name)) {
        const std::size_t second = bytes_.find_first_of(",\n$", pos_);
        if (second == std::string_view::npos || bytes_[second] != ',') fail(pos_, "$$PARAM has no value");
        pos_ = second + 1;
        *target = expect_number("the value of $$PARAM");
        expect_end("PARAM");
        return;
      }
    }
    unknown("PARAM");
  }

  void parse_text() {
    bool started = false;
    bool ended = false;
    while (!ended) {
      const std::optional<Command> command = next_command();
      if (!command) fail(bytes_.size(), "the file ends before $$GEOMETRYEND");
      const std::string_view k = command->keyword;
      const bool geometry = k == "LAYER" || k == "POLYLINE" || k == "HATCHES";
      if (geometry && !started) {
        note(Severity::Repair, "geometry_start_missing", "$$GEOMETRYSTART is missing");
        started = true;
      }
      if (k == "GEOMETRYSTART") {
        if (started) repeated(k);
        started = true;
      } else if (k == "GEOMETRYEND") {
        if (!started) note(Severity::Repair, "geometry_start_missing", "$$GEOMETRYSTART is missing");
        ended = true;
      } else if (k == "LAYER") {
        const double z = expect_number("the z of a layer");
        expect_end("LAYER");
        add_layer(command->byte, z, false);
      } else if (k == "POLYLINE") {
        text_polyline(*command);
      } else if (k == "HATCHES") {
        text_hatches(*command);
      } else if (k == "PARAM") {
        text_param();
      } else if (k == "UNITS" || k == "BINARY" || k == "ASCII") {
        fail(command->byte, "$$" + std::string(k) + " behind the header");
      } else if (std::optional<double>* target = modal(k)) {
        text_modal(*command, *target);
      } else if (!started && k != "HEADERSTART" && header_keyword(*command)) {
        note(Severity::Repair, "header_keyword_late", "$$" + std::string(k) + " stands behind $$HEADEREND");
      } else {
        unknown(k);
      }
    }
    skip_blanks();
    if (!at_end()) note(Severity::Note, "trailing_data", "what follows $$GEOMETRYEND is ignored");
  }

  // ---- binary geometry

  static constexpr std::size_t kAlignment = 4;  ///< bytes, with $$ALIGN

  void need(std::size_t n, std::size_t command) const {
    if (bytes_.size() - pos_ < n) fail(command, "the file ends inside this command");
  }
  [[nodiscard]] std::uint16_t peek16(std::size_t at) const {
    const auto* p = reinterpret_cast<const unsigned char*>(bytes_.data()) + at;
    return static_cast<std::uint16_t>(p[0] | (p[1] << 8));
  }
  std::uint16_t u16() {
    const std::uint16_t value = peek16(pos_);
    pos_ += 2;
    return value;
  }
  std::uint32_t u32() {
    const std::uint32_t low = u16();
    return low | (static_cast<std::uint32_t>(u16()) << 16);
  }
  std::int32_t i32() {
    const std::uint32_t bits = u32();
    std::int32_t value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  double f32() {
    const std::uint32_t bits = u32();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return static_cast<double>(value);
  }
  /// With $$ALIGN: skip to the next multiple of 32 bits, counted from the start of the geometry.
  void align(std::size_t origin) {
    if (!align_) return;
    const std::size_t odd = (pos_ - origin) % kAlignment;
    if (odd != 0) pos_ = std::min(pos_ + kAlignment - odd, bytes_.size());
  }

  /// The payload of a polyline or of hatches: the count, checked against the bytes that are left.
  std::size_t binary_count(bool is_short, std::size_t numbers_each, std::size_t command) {
    const std::size_t width = is_short ? 2 : 4;
    need(width, command);
    const std::size_t at = pos_;
    const std::int64_t n = is_short ? static_cast<std::int64_t>(u16()) : static_cast<std::int64_t>(i32());
    if (n < 0) fail(at, "a count is negative");
    if (static_cast<std::uint64_t>(n) > (bytes_.size() - pos_) / (width * numbers_each))
      fail(at, "a count is " + std::to_string(n) + ", more than the rest of the file can hold");
    return static_cast<std::size_t>(n);
  }

  double binary_coordinate(bool is_short) {
    const std::size_t begin = pos_;
    const double value = is_short ? static_cast<double>(u16()) : f32();
    // Whether 16 bits have a sign is known at the end: here, what is in range either way passes.
    check_coordinate(begin, is_short ? std::min(value, std::abs(wrapped(value))) : value);
    if (is_short) has_shorts_ = true;
    return value;
  }

  void binary_polyline(bool is_short, std::size_t command) {
    Layer& layer = current_layer(command, "a polyline");
    need(is_short ? 4 : 8, command);
    Polyline line;
    line.part = is_short ? static_cast<std::int32_t>(u16()) : i32();
    const std::size_t at = pos_;
    const std::int32_t dir = is_short ? static_cast<std::int32_t>(u16()) : i32();
    if (dir < 0 || dir > 2) fail(at, "the direction of a polyline is " + std::to_string(dir) + ", not 0, 1 or 2");
    line.direction = static_cast<Direction>(dir);
    const std::size_t n = binary_count(is_short, 2, command);
    line.points.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      listen_();
      Point2 p;
      p.x = binary_coordinate(is_short);
      p.y = binary_coordinate(is_short);
      line.points.push_back(p);
    }
    if (is_short) short_blocks_.push_back({stack_.layers.size() - 1, layer.polylines.size(), false});
    layer.polylines.push_back(std::move(line));
  }

  void binary_hatches(bool is_short, std::size_t command) {
    Layer& layer = current_layer(command, "hatches");
    need(is_short ? 2 : 4, command);
    Hatches hatches;
    hatches.part = is_short ? static_cast<std::int32_t>(u16()) : i32();
    const std::size_t n = binary_count(is_short, 4, command);
    hatches.lines.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
      listen_();
      std::array<double, 4> v{};
      for (double& value : v) value = binary_coordinate(is_short);
      hatches.lines.push_back({Point2{v[0], v[1]}, Point2{v[2], v[3]}});
    }
    if (is_short) short_blocks_.push_back({stack_.layers.size() - 1, layer.hatches.size(), true});
    layer.hatches.push_back(std::move(hatches));
  }

  void parse_binary() {
    text_end_ = pos_;
    while (!at_end() && (bytes_[pos_] == '\r' || bytes_[pos_] == '\n')) ++pos_;
    const std::size_t origin = pos_;
    while (!at_end()) {
      listen_();
      const std::size_t command = pos_;
      if (bytes_.size() - pos_ < 2 || peek16(pos_) == 0) {
        // Some writers fill the last block of the file.
        if (bytes_.find_first_not_of(std::string_view("\0\r\n\x1a", 4), pos_) == std::string_view::npos) {
          note(Severity::Note, "trailing_data", "filling bytes at the end of the file are ignored");
          return;
        }
        if (bytes_.size() - pos_ < 2) fail(command, "the file ends inside a command");
      }
      const unsigned code = u16();
      align(origin);
      switch (code) {
        case 127:
          need(4, command);
          {
            const double z = f32();
            if (!std::isfinite(z)) fail(command, "the z of a layer is not finite");
            add_layer(command, z, false);
          }
          break;
        case 128:
          need(2, command);
          add_layer(command, static_cast<double>(u16()), true);
          break;
        case 129: binary_polyline(true, command); break;
        case 130: binary_polyline(false, command); break;
        case 131: binary_hatches(true, command); break;
        case 132: binary_hatches(false, command); break;
        default: fail(command, "unknown binary command " + std::to_string(code));
      }
      align(origin);
    }
  }

  // ---- after reading

  struct ShortBlock {
    std::size_t layer;
    std::size_t index;
    bool hatches;
  };

  template <class Visit>
  void for_short_coordinates(Visit visit) {
    for (const ShortBlock& block : short_blocks_) for_short_coordinates(block, visit);
  }
  template <class Visit>
  void for_short_coordinates(const ShortBlock& block, Visit visit) {
    Layer& layer = stack_.layers[block.layer];
    listen_(1 +
            (block.hatches ? 2 * layer.hatches[block.index].lines.size() : layer.polylines[block.index].points.size()));
    if (block.hatches) {
      for (std::array<Point2, 2>& line : layer.hatches[block.index].lines)
        for (Point2& p : line) visit(p);
    } else {
      for (Point2& p : layer.polylines[block.index].points) visit(p);
    }
  }

  static double wrapped(double value) { return value >= 32768 ? value - 65536 : value; }

  /// Are 16-bit coordinates meant as signed ones?
  bool shorts_are_signed() {
    if (options_.short_coordinates != CliShortCoordinates::Auto)
      return options_.short_coordinates == CliShortCoordinates::Signed;
    if (!stack_.dimension || !has_shorts_) return false;
    const std::array<double, 6>& d = *stack_.dimension;
    // A minimum that rounds to -1 unit or less cannot be written unsigned.
    if (d[0] / stack_.unit < -0.5 || d[1] / stack_.unit < -0.5) return true;
    struct Range {
      double low = std::numeric_limits<double>::infinity();
      double high = -std::numeric_limits<double>::infinity();
      void add(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
      }
    };
    std::array<Range, 2> plain;
    std::array<Range, 2> wrap;
    for_short_coordinates([&](const Point2& p) {
      plain[0].add(p.x);
      plain[1].add(p.y);
      wrap[0].add(wrapped(p.x));
      wrap[1].add(wrapped(p.y));
    });
    // Paths may overshoot the part's box by a beam or a support; a wrapped value misses it by far more.
    const auto fits = [&](const std::array<Range, 2>& r) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double low = d[axis] / stack_.unit;
        const double high = d[axis + 3] / stack_.unit;
        const double slack = 1 + 0.25 * (high - low);
        if (r[axis].low < low - slack || r[axis].high > high + slack) return false;
      }
      return true;
    };
    return !fits(plain) && fits(wrap);
  }

  void resolve_shorts() {
    if (has_shorts_ && shorts_are_signed()) {
      for_short_coordinates([&](Point2& p) {
        wrapped_.add(-1, -1, (p.x >= 32768 ? 1u : 0u) + (p.y >= 32768 ? 1u : 0u));
        p.x = wrapped(p.x);
        p.y = wrapped(p.y);
      });
    }
    for (const ShortBlock& block : short_blocks_)
      for_short_coordinates(block, [&](const Point2& p) {
        if (std::abs(p.x) > limit_ || std::abs(p.y) > limit_)
          fail_at_layer(block.layer, "a coordinate of the layer is out of range (1e6 mm)");
      });
    const bool signed_z = options_.short_coordinates == CliShortCoordinates::Signed ||
                          (options_.short_coordinates == CliShortCoordinates::Auto && stack_.dimension &&
                           (*stack_.dimension)[2] / stack_.unit < -0.5);
    if (signed_z) {
      for (const std::size_t i : short_layers_) {
        wrapped_.add(-1, -1, stack_.layers[i].z >= 32768 ? 1 : 0);
        stack_.layers[i].z = wrapped(stack_.layers[i].z);
      }
    }
  }

  /// Layers ascend: a file that descends as a whole is turned around, layers of equal z become one.
  void order_layers() {
    std::vector<Layer>& layers = stack_.layers;
    std::size_t up = layers.size();  // first steps of either kind
    std::size_t down = layers.size();
    for (std::size_t i = layers.size(); i-- > 1;) {
      if (layers[i].z > layers[i - 1].z) up = i;
      if (layers[i].z < layers[i - 1].z) down = i;
    }
    if (up < layers.size() && down < layers.size())
      fail_at_layer(std::max(up, down), "the z of the layers neither ascends nor descends throughout");
    if (down < layers.size()) {
      std::reverse(layers.begin(), layers.end());
      note(Severity::Repair, "layers_descend", "the layers were in descending order and have been turned around");
    }
    std::size_t last = 0;
    for (std::size_t i = 1; i < layers.size(); ++i) {
      if (layers[i].z == layers[last].z) {
        repeated_z_.add(static_cast<std::int64_t>(last));
        Layer& into = layers[last];
        std::move(layers[i].polylines.begin(), layers[i].polylines.end(), std::back_inserter(into.polylines));
        std::move(layers[i].hatches.begin(), layers[i].hatches.end(), std::back_inserter(into.hatches));
      } else if (++last != i) {
        layers[last] = std::move(layers[i]);
      }
    }
    if (!layers.empty()) layers.resize(last + 1);
  }

  [[noreturn]] void fail_at_layer(std::size_t layer, const std::string& message) const {
    fail(static_cast<std::size_t>(layer_bytes_[layer]), message);
  }

  void resolve_z_unit() {
    stack_.z_unit = stack_.unit;
    if (options_.z_unit == CliZUnit::Millimeters) stack_.z_unit = 1;
    if (options_.z_unit != CliZUnit::Auto || stack_.layers.empty()) return;
    std::vector<double> steps;
    for (std::size_t i = 1; i < stack_.layers.size(); ++i) steps.push_back(stack_.layers[i].z - stack_.layers[i - 1].z);
    if (steps.empty()) steps.push_back(std::abs(stack_.layers.front().z));
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>((steps.size() - 1) / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double step = *middle;
    const auto sane = [](double h) { return h >= kCliThinnestLayer && h <= kCliThickestLayer; };
    const bool sane_units = sane(step * stack_.unit);
    if (stack_.unit != 1 && sane(step)) {
      // The top of the box is two layers or 1 % away from the last layer at most, whatever z means in its layer.
      bool box_says_mm = false;
      if (stack_.dimension && (*stack_.dimension)[5] > (*stack_.dimension)[2]) {
        const double top = (*stack_.dimension)[5];
        double last = stack_.layers.back().z;
        for (std::size_t i = stack_.layers.size(); i-- > 0;) {
          if (stack_.layers[i].polylines.empty() && stack_.layers[i].hatches.empty()) continue;
          last = stack_.layers[i].z;
          break;
        }
        const auto fits = [&](double unit) {
          return std::abs(last * unit - top) <= std::max(2 * step * unit, 0.01 * std::abs(top));
        };
        box_says_mm = fits(1) && !fits(stack_.unit);
      }
      if (box_says_mm || !sane_units) {
        stack_.z_unit = 1;
        note(Severity::Warning, "z_in_millimeters",
             std::string("z is taken as mm, not as units, because ") +
                 (box_says_mm ? "only then it fits to $$DIMENSION" : "only then a layer is 1 micron to 10 mm thick") +
                 " (option z_unit)");
        return;
      }
    }
    if (!sane_units)
      note(Severity::Warning, "thickness_implausible", "the distance of the layers is not between 1 micron and 10 mm");
  }

  /// Drop repeated points, take the closing point off closed lines, drop what encloses or draws nothing.
  void clean_polylines() {
    const bool close = close_lines();
    for (std::size_t l = 0; l < stack_.layers.size(); ++l) {
      std::vector<Polyline>& lines = stack_.layers[l].polylines;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        Polyline& line = lines[i];
        listen_(1 + line.points.size());
        const auto layer = static_cast<std::int64_t>(l);
        const auto index = static_cast<std::int64_t>(i);
        std::vector<Point2>& p = line.points;
        const std::size_t before = p.size();
        p.erase(std::unique(p.begin(), p.end()), p.end());
        zero_segments_.add(layer, index, before - p.size());
        if (p.empty()) {
          empty_.add(layer, index);
          continue;
        }
        bool was_open = false;
        if (line.direction == Direction::Open && p.size() > 3 && p.front() == p.back()) {
          if (close && encloses(p)) {
            was_open = true;
            closed_.add(layer, index);
          } else {
            left_open_.add(layer, index);
          }
        }
        if (line.direction != Direction::Open || was_open) {
          if (p.size() > 1 && p.front() == p.back())
            p.pop_back();
          else if (p.size() > 2)
            unclosed_.add(layer, index);
          if (p.size() < 3) {
            degenerate_.add(layer, index);
            continue;
          }
        }
        if (was_open) line.direction = kUndecided;
        if (kept != i) lines[kept] = std::move(line);
        ++kept;
      }
      lines.resize(kept);
    }
  }

  static bool encloses(const std::vector<Point2>& p) { return winding_sign(p) != 0; }

  bool close_lines() const {
    if (options_.close_lines != CliCloseLines::Auto) return options_.close_lines == CliCloseLines::Always;
    if (has_parameters_) return true;
    bool any = false;
    for (const Layer& layer : stack_.layers) {
      for (const Polyline& line : layer.polylines) {
        if (line.direction != Direction::Open || line.points.size() < 4 || line.points.front() != line.points.back())
          return false;
        any = true;
      }
    }
    return any;
  }

  /// A closed line of dir 2 until `orient` has decided.
  static constexpr Direction kUndecided = static_cast<Direction>(3);

  void orient() {
    CliOrientation rule = options_.orientation;
    if (rule == CliOrientation::Auto) {
      rule = CliOrientation::Dir;
      std::uint64_t holes = 0;
      std::uint64_t others = 0;
      for (const Layer& layer : stack_.layers)
        for (const Polyline& line : layer.polylines) {
          if (line.direction == Direction::Inner) ++holes;
          if (line.direction == Direction::Outer || line.direction == kUndecided) ++others;
        }
      if (holes > 0 && others == 0) {
        rule = CliOrientation::Nesting;
        note(Severity::Repair, "all_contours_are_holes",
             "every contour has direction 0 (hole); outer boundaries and holes are told apart by nesting");
      }
    }
    for (std::size_t l = 0; l < stack_.layers.size(); ++l) {
      std::vector<Polyline>& lines = stack_.layers[l].polylines;
      nest(l, lines, rule == CliOrientation::Nesting);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        Polyline& line = lines[i];
        listen_(1 + line.points.size());
        if (line.direction == Direction::Open) continue;
        const int sign = winding_sign(line.points);
        if (rule == CliOrientation::Winding || line.direction == kUndecided) {
          const Direction by_winding = sign < 0 ? Direction::Inner : Direction::Outer;
          if (line.direction == kUndecided)
            line.direction = by_winding;
          else if (sign != 0)
            set_direction(line, by_winding, l, i);
        }
        if ((line.direction == Direction::Outer && sign < 0) || (line.direction == Direction::Inner && sign > 0)) {
          reverse_loop(line.points);
          reversed_.add(static_cast<std::int64_t>(l), static_cast<std::int64_t>(i));
        }
      }
    }
  }

  void set_direction(Polyline& line, Direction direction, std::size_t layer, std::size_t index) {
    if (line.direction == direction) return;
    if (line.direction != kUndecided)
      redirected_.add(static_cast<std::int64_t>(layer), static_cast<std::int64_t>(index));
    line.direction = direction;
  }

  /// Decide the direction of the undecided contours of a layer, or of all of them, by nesting.
  void nest(std::size_t l, std::vector<Polyline>& lines, bool all) {
    std::map<std::int32_t, std::vector<std::size_t>> parts;
    std::map<std::int32_t, bool> wanted;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].direction == Direction::Open) continue;
      parts[lines[i].part].push_back(i);
      if (all || lines[i].direction == kUndecided) wanted[lines[i].part] = true;
    }
    for (const auto& [part, indices] : parts) {
      if (wanted.count(part) == 0) continue;
      std::vector<const std::vector<Point2>*> loops;
      loops.reserve(indices.size());
      for (const std::size_t i : indices) loops.push_back(&lines[i].points);
      const std::vector<std::optional<bool>> inside = nesting_parity(loops, listen_);
      for (std::size_t k = 0; k < indices.size(); ++k) {
        Polyline& line = lines[indices[k]];
        if (!all && line.direction != kUndecided) continue;
        if (inside[k]) {
          set_direction(line, *inside[k] ? Direction::Inner : Direction::Outer, l, indices[k]);
        } else {
          nesting_undecided_.add(static_cast<std::int64_t>(l), static_cast<std::int64_t>(indices[k]));
          line.direction = kUndecided;
        }
      }
    }
  }

  void report() {
    if (announced_layers_ && static_cast<std::uint64_t>(std::max(*announced_layers_, 0)) != layer_bytes_.size())
      note(Severity::Note, "layer_count_differs",
           "the header announces " + std::to_string(*announced_layers_) + " layers, the file has " +
               std::to_string(layer_bytes_.size()));
    if (stack_.layers.empty()) note(Severity::Warning, "no_layers", "the file has no layers");
    for (const auto& [keyword, n] : unknown_)
      if (diagnostics_ != nullptr)
        diagnostics_->add(Severity::Note, Stage::Read, "unknown_keyword", "$$" + keyword + " is skipped", -1, -1, n);
    stray_.report(diagnostics_, Severity::Warning, "stray_text", "text that belongs to no command is skipped");
    unclosed_comments_.report(diagnostics_, Severity::Repair, "unclosed_comment",
                              "a comment is not closed; it ends with its line");
    wrapped_.report(diagnostics_, Severity::Repair, "signed_short_coordinates",
                    "16-bit coordinates of 32768 and more are meant as negative ones, judged by $$DIMENSION");
    repeated_z_.report(diagnostics_, Severity::Repair, "layer_repeated", "layers of equal z are merged into one");
    point_count_.report(diagnostics_, Severity::Repair, "point_count_off_by_one",
                        "a polyline has one point more than it announces; all are kept");
    zero_segments_.report(diagnostics_, Severity::Repair, "zero_length_segment", "segments of length zero are dropped");
    empty_.report(diagnostics_, Severity::Repair, "empty_polyline", "polylines without points are dropped");
    degenerate_.report(diagnostics_, Severity::Repair, "degenerate_contour",
                       "contours of less than three different points are dropped");
    unclosed_.report(diagnostics_, Severity::Repair, "unclosed_contour",
                     "a contour does not end where it began; it is closed by a straight edge");
    closed_.report(diagnostics_, Severity::Repair, "open_line_closed",
                   "open lines (dir 2) that end where they began are read as contours (option close_lines)");
    left_open_.report(diagnostics_, Severity::Note, "open_line_with_equal_ends",
                      "open lines that end where they began are kept as open lines (option close_lines)");
    redirected_.report(
        diagnostics_, Severity::Repair, "direction_corrected",
        "contours whose dir does not agree with winding or nesting get another one (option orientation)");
    reversed_.report(diagnostics_, Severity::Repair, "contour_reversed",
                     "contours whose points are not in the order of their direction are reversed");
    nesting_undecided_.report(diagnostics_, Severity::Warning, "nesting_too_costly",
                              "too many contours in one layer to compare all; the rest is oriented by winding");
  }

  std::string_view bytes_;
  CliReadOptions options_;
  Diagnostics* diagnostics_;
  std::string source_;
  static constexpr std::size_t kPollEvery = 1 << 16;  // numbers, points and commands
  Poll listen_;

  std::size_t pos_ = 0;
  std::size_t text_end_ = 0;  ///< bytes up to here are text: errors there have a line
  bool in_header_ = false;
  bool binary_ = false;
  bool align_ = false;
  std::optional<bool> encoding_;
  std::optional<double> units_;
  std::optional<int> announced_layers_;
  double limit_ = 0;
  double z_limit_ = 0;
  ProcessParameters process_;
  bool has_parameters_ = false;
  bool has_shorts_ = false;
  SliceStack stack_;
  std::vector<std::uint64_t> layer_bytes_;
  std::vector<std::size_t> short_layers_;
  std::vector<ShortBlock> short_blocks_;
  std::map<std::string, std::uint64_t> unknown_;

  CliTally stray_, unclosed_comments_, wrapped_, repeated_z_, point_count_, zero_segments_, empty_, degenerate_,
      unclosed_, closed_, left_open_, redirected_, reversed_, nesting_undecided_;
};

/// All bytes of a stream, in blocks: memory proportional to what is there.
inline std::string read_all(std::istream& stream, const std::string& name, const std::function<void()>& poll) {
  std::string bytes;
  std::vector<char> block(std::size_t{1} << 16);
  while (stream) {
    if (poll) poll();
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    bytes.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad() || !stream.eof()) throw FileError(Stage::Read, name, "cannot be read");
  return bytes;
}

}  // namespace detail

/// Read a CLI file from memory: its `bytes`, text or binary.
///
/// The stack holds the file's numbers (multiply by `unit` and `z_unit` for mm), layers with strictly ascending z,
/// closed contours without the repeated last point, outer ones counter-clockwise and holes clockwise, no two equal
/// points in a row, polylines and hatches with part ids and the process parameters that hold for them.
///
/// Repairs and notes go to `diagnostics` (may be null), one per code or keyword with its count: `zero_length_segment`,
/// `contour_reversed` (dir decides, the points are reversed), `open_line_closed`, `all_contours_are_holes`,
/// `direction_corrected`, `unclosed_contour`, `degenerate_contour`, `empty_polyline`, `point_count_off_by_one`,
/// `layer_repeated` (layers of equal z in a row are merged), `layers_descend` (a file that descends throughout is
/// turned around; one that goes up and down is an error), `signed_short_coordinates`, `z_in_millimeters`,
/// `thickness_implausible`, `unknown_keyword`, `stray_text`, `unclosed_comment`, `header_keyword_repeated`,
/// `header_keyword_late`, `header_value_unreadable`, `header_end_missing`, `geometry_start_missing`,
/// `encoding_missing`, `layer_count_differs`, `userdata_skipped`, `trailing_data`, `no_layers`.
///
/// With `$$ALIGN`, every binary command index and every command is filled up to a multiple of 32 bits from the start of
/// the geometry. No file that has it was ever seen.
///
/// Errors: ParseError with byte and line for everything else that is not a CLI file, among it a text file without
/// `$$GEOMETRYEND` (it was cut off); OptionError for `options.unit`; what `options.poll` throws.
/// Cost: linear in the number of bytes (sorting in a layer where nesting is asked for), memory proportional to it.
/// `source_name` appears in messages.
[[nodiscard]] inline SliceStack parse_cli(std::string_view bytes, const CliReadOptions& options = {},
                                          Diagnostics* diagnostics = nullptr, std::string source_name = {}) {
  return detail::CliParser(bytes, options, diagnostics, std::move(source_name)).parse();
}

/// Read a CLI file from a stream (opened in binary mode). See `parse_cli`; FileError when the stream fails.
[[nodiscard]] inline SliceStack read_cli(std::istream& stream, const CliReadOptions& options = {},
                                         Diagnostics* diagnostics = nullptr, std::string source_name = {}) {
  const std::string bytes = detail::read_all(stream, source_name.empty() ? "<stream>" : source_name, options.poll);
  return parse_cli(bytes, options, diagnostics, std::move(source_name));
}

/// Read a CLI file. See `parse_cli`; FileError when it cannot be opened or read.
[[nodiscard]] inline SliceStack read_cli(const std::string& path, const CliReadOptions& options = {},
                                         Diagnostics* diagnostics = nullptr) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw FileError(Stage::Read, path, "is a folder");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const int code = errno;
    throw FileError(Stage::Read, path,
                    "cannot be opened" + (code != 0 ? ": " + std::generic_category().message(code) : std::string()));
  }
  return read_cli(file, options, diagnostics, path);
}

}  // namespace slice2mesh
