// SPDX-License-Identifier: MIT
#include "slice2mesh/cli/read_cli.hpp"

#include <clocale>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "cli_samples.hpp"

using namespace slice2mesh;
using namespace slice2mesh_test;

namespace {

struct Read {
  SliceStack stack;
  Diagnostics diagnostics;
};

Read read(const std::string& bytes, const CliReadOptions& options = {}) {
  Read r;
  r.stack = parse_cli(bytes, options, &r.diagnostics, "sample");
  return r;
}

/// The error that reading ends with; fails when there is none.
ParseError error_of(const std::string& bytes) {
  try {
    (void)read(bytes);
  } catch (const ParseError& e) {
    return e;
  }
  FAIL("no ParseError");
  return ParseError("", 0, 0, "");
}

const std::vector<Point2> kSquarePoints{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

}  // namespace

TEST_CASE("A text file gives layers, polylines, hatches, labels and the header's numbers", "[cli]") {
  const Read r = read(text_file("$$LAYER/0.5\n" + std::string(kSquare) +
                                    "$$POLYLINE/2,2,3,0,0,1,1,2,0\n$$HATCHES/2,2,0,0,1,1,2,2,3,3\n$$LAYER/1\n",
                                "$$UNITS/0.1\n$$VERSION/200\n$$DATE/010203\n$$LAYERS/000002\n"
                                "$$DIMENSION/0,0,0,,1.5,2,3,\n$$LABEL/1,part one\n$$LABEL/2,b,c\n"));
  CHECK(r.diagnostics.empty());
  const SliceStack& s = r.stack;
  CHECK(s.unit == 0.1);
  CHECK(s.z_unit == 0.1);
  CHECK(s.version == 200);
  CHECK(s.date == 10203);
  REQUIRE(s.dimension);
  CHECK(*s.dimension == std::array<double, 6>{0, 0, 0, 1.5, 2, 3});
  CHECK(s.labels.at(1) == "part one");
  CHECK(s.labels.at(2) == "b,c");
  CHECK(s.source == "sample");
  REQUIRE(s.layers.size() == 2);
  CHECK(s.layers[0].z == 0.5);
  REQUIRE(s.layers[0].polylines.size() == 2);
  CHECK(s.layers[0].polylines[0].part == 1);
  CHECK(s.layers[0].polylines[0].direction == Direction::Outer);
  CHECK(s.layers[0].polylines[0].points == kSquarePoints);
  CHECK(s.layers[0].polylines[1].direction == Direction::Open);
  CHECK(s.layers[0].polylines[1].points.size() == 3);
  REQUIRE(s.layers[0].hatches.size() == 1);
  CHECK(s.layers[0].hatches[0].lines[1][0] == Point2{2, 2});
  CHECK(s.layers[1].polylines.empty());
}

TEST_CASE("Line ends, wrapping, comments and the way numbers are written do not matter", "[cli]") {
  const SliceStack plain = read(text_file("$$LAYER/0.5\n" + std::string(kSquare))).stack;
  const std::string one_line =
      "rubbish before\n$$HEADERSTART$$ASCII$$UNITS/1$$HEADEREND$$GEOMETRYSTART$$LAYER/0.5"
      "$$POLYLINE/1,1,5,0,0,1,0,1,1,0,1,0,0$$GEOMETRYEND";
  CHECK(read(one_line).stack == plain);
  const std::string wrapped =
      "$$HEADERSTART\r\n// $$UNITS/7 is a comment\r\n over lines ////x//$$ASCII // so // \r\n$$UNITS/00000001.000 "
      "// mm //\r\n$$HEADEREND\r\n$$GEOMETRYSTART\r\n$$LAYER/ .5\r\n$$POLYLINE/1, +1 ,5,\r\n0,0,+1.0,-0.0,1e0,\r\n"
      "10E-1 , 0.0,1 // half // ,0,0\r\n$$GEOMETRYEND\r\n";
  CHECK(read("$$HEADERSTART\n// one // $$ASCII // two //\n$$UNITS/1//three//\n$$HEADEREND\n$$GEOMETRYSTART\n"
             "$$LAYER/ .5 // z //\n$$POLYLINE/1, +1 ,5,\r\n0,0,+1.0,-0.0,1e0,\r\n10E-1 , 0.0,1 // half // ,0,0,\r\n"
             "$$GEOMETRYEND")
            .stack == plain);
  // A comment may hold a command when it is closed on its line.
  CHECK(read(text_file("// $$LAYER/9 //\n$$LAYER/0.5\n" + std::string(kSquare))).stack == plain);
  // One that is not closed ends with its line, and this is said.
  const Read open = read(text_file("// layers follow\n$$LAYER/0.5\n// square\n" + std::string(kSquare)));
  CHECK(open.stack == plain);
  CHECK(open.diagnostics.count("unclosed_comment") == 2);
  // One without a command may stand on several lines.
  CHECK(read(wrapped).stack == plain);
}

TEST_CASE("The locale does not change numbers", "[cli]") {
  const std::string bytes = text_file("$$LAYER/0.25\n" + std::string(kSquare));
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* changed = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE", "fr_FR.UTF-8"})
    if (changed == nullptr) changed = std::setlocale(LC_ALL, name);
  const SliceStack stack = read(bytes).stack;
  const std::string again = written(stack);
  std::setlocale(LC_ALL, before.c_str());
  CHECK(stack.layers[0].z == 0.25);
  CHECK(again.find("0.25") != std::string::npos);
  if (changed == nullptr) WARN("no locale with a decimal comma is installed");
}

TEST_CASE("Binary long and short commands mix and CR LF behind the header is tolerated", "[cli]") {
  for (const char* gap : {"", "\n", "\r\n"}) {
    BinaryFile f("$$UNITS/0.5\n");
    f.bytes += gap;
    f.u16(127).f32(1.5f);
    f.u16(130).u32(3).u32(1).u32(4).f32(0).f32(0).f32(1).f32(0).f32(1).f32(1).f32(0).f32(0);
    f.u16(128).u16(2);
    f.u16(129).u16(4).u16(2).u16(2).u16(0).u16(65535).u16(7).u16(8);
    f.u16(131).u16(5).u16(1).u16(1).u16(2).u16(3).u16(4);
    f.u16(132).u32(6).u32(1).f32(-1).f32(2).f32(3).f32(4.5f);
    const SliceStack s = read(f.bytes).stack;
    REQUIRE(s.layers.size() == 2);
    CHECK(s.layers[0].z == 1.5);
    CHECK(s.layers[0].polylines[0].points == std::vector<Point2>{{0, 0}, {1, 0}, {1, 1}});
    CHECK(s.layers[1].z == 2);
    CHECK(s.layers[1].polylines[0].part == 4);
    CHECK(s.layers[1].polylines[0].points == std::vector<Point2>{{0, 65535}, {7, 8}});
    CHECK(s.layers[1].hatches[0].lines[0][1] == Point2{3, 4});
    CHECK(s.layers[1].hatches[1].part == 6);
    CHECK(s.layers[1].hatches[1].lines[0][1] == Point2{3, 4.5});
  }
}

TEST_CASE("Aligned binary data is filled up to 32 bits after the index and at the end of a command", "[cli]") {
  BinaryFile f("$$UNITS/1\n$$ALIGN\n");
  f.u16(128).u16(0).u16(2).u16(0);
  f.u16(129).u16(0).u16(1).u16(2).u16(1).u16(9).u16(8).u16(0);
  f.u16(127).u16(0).f32(3);
  const SliceStack s = read(f.bytes).stack;
  REQUIRE(s.layers.size() == 2);
  CHECK(s.layers[0].polylines[0].points == std::vector<Point2>{{9, 8}});
  CHECK(s.layers[1].z == 3);
}

TEST_CASE("Short coordinates are signed when the box of the header says so", "[cli]") {
  const auto file = [](const std::string& header) {
    BinaryFile f("$$UNITS/0.01\n" + header);
    f.u16(128).u16(1).u16(129).u16(1).u16(1).u16(4);
    f.u16(65436).u16(0).u16(100).u16(0).u16(100).u16(100).u16(65436).u16(0);
    return f.bytes;
  };
  const auto x = [](const Read& r) { return r.stack.layers.at(0).polylines.at(0).points.at(0).x; };
  CHECK(x(read(file(""))) == 65436);
  CHECK(x(read(file("$$DIMENSION/-1,0,0,1,1,1\n"))) == -100);
  CHECK(read(file("$$DIMENSION/-1,0,0,1,1,1\n")).diagnostics.count("signed_short_coordinates") == 2);
  CHECK(x(read(file("$$DIMENSION/0,0,0,5,5,1\n"))) == -100);     // fits only when wrapped
  CHECK(x(read(file("$$DIMENSION/0,0,0,655,5,1\n"))) == 65436);  // fits as it is
  CliReadOptions options;
  options.short_coordinates = CliShortCoordinates::Signed;
  CHECK(x(read(file("$$DIMENSION/0,0,0,655,5,1\n"), options)) == -100);
  options.short_coordinates = CliShortCoordinates::Unsigned;
  CHECK(x(read(file("$$DIMENSION/-1,0,0,1,1,1\n"), options)) == 65436);
}

TEST_CASE("User data is skipped by its length, whatever bytes it has", "[cli]") {
  const std::string data("$$HEADEREND\0\n,//", 16);
  const Read r = read("$$HEADERSTART\n$$ASCII\n$$USERDATA/me,16," + data +
                      "\n$$UNITS/2\n$$HEADEREND\n$$GEOMETRYSTART$$LAYER/1$$GEOMETRYEND");
  CHECK(r.stack.unit == 2);
  CHECK(r.diagnostics.count("userdata_skipped") == 1);
  CHECK_FALSE(parses("$$HEADERSTART\n$$ASCII\n$$USERDATA/me,1000000,x\n$$UNITS/2\n$$HEADEREND\n"));
  CHECK_FALSE(parses("$$HEADERSTART\n$$ASCII\n$$USERDATA/me,-4,x\n$$UNITS/2\n$$HEADEREND\n"));
  CHECK_FALSE(parses("$$HEADERSTART\n$$ASCII\n$$USERDATA/me\n$$UNITS/2\n$$HEADEREND\n"));
}

TEST_CASE("Process parameters hold until they change, also from before the first polyline", "[cli]") {
  const Read r = read(text_file(
      "$$POWER/50\n$$LAYER/1\n$$POLYLINE/1,1,5,0,0,1,0,1,1,0,1,0,0\n$$SPEED/200.5\n$$HATCHES/1,1,0,0,1,1\n$$LAYER/2\n"
      "$$PARAM/Power, float, 70\n$$FOCUS/1$$SPOTSIZE/.5\n$$PARAM/gas, string, argon\n$$HATCHES/1,1,0,0,1,1\n"));
  const SliceStack& s = r.stack;
  CHECK(s.layers[0].polylines[0].process.power == 50);
  CHECK_FALSE(s.layers[0].polylines[0].process.speed);
  CHECK(s.layers[0].hatches[0].process.power == 50);
  CHECK(s.layers[0].hatches[0].process.speed == 200.5);
  CHECK(s.layers[1].hatches[0].process.power == 70);
  CHECK(s.layers[1].hatches[0].process.speed == 200.5);
  CHECK(s.layers[1].hatches[0].process.focus == 1);
  CHECK(s.layers[1].hatches[0].process.spot_size == 0.5);
  CHECK(r.diagnostics.count("unknown_keyword") == 1);
  CHECK_FALSE(parses(text_file("$$POWER/nan\n$$LAYER/1\n")));
}

TEST_CASE("Unknown commands are skipped with one finding for each keyword", "[cli]") {
  std::string geometry = "$$LAYER/1\n";
  for (int i = 0; i < 50; ++i) geometry += "$$COLOR/1,2,nan,'red'\n$$GLUE\n";
  const Read r = read(text_file(geometry + kSquare, "$$UNITS/1\n$$MACHINE/x/y\n"));
  CHECK(r.stack.layers[0].polylines.size() == 1);
  CHECK(r.diagnostics.entries().size() == 3);
  CHECK(r.diagnostics.count("unknown_keyword") == 101);
}

TEST_CASE("Dir decides between hole and outer boundary and the points follow", "[cli]") {
  const std::string clockwise = "$$POLYLINE/1,1,5,0,0,0,1,1,1,1,0,0,0\n";
  const std::string hole = "$$POLYLINE/1,0,5,0,0,1,0,1,1,0,1,0,0\n";
  const Read r = read(text_file("$$LAYER/1\n" + clockwise + hole + kSquare));
  const std::vector<Polyline>& lines = r.stack.layers[0].polylines;
  CHECK(lines[0].direction == Direction::Outer);
  CHECK(lines[0].points == kSquarePoints);
  CHECK(lines[1].direction == Direction::Inner);
  CHECK(lines[1].points == std::vector<Point2>{{0, 0}, {0, 1}, {1, 1}, {1, 0}});
  CHECK(r.diagnostics.count("contour_reversed") == 2);
  CliReadOptions options;
  options.orientation = CliOrientation::Winding;
  const Read w = read(text_file("$$LAYER/1\n" + clockwise + hole + kSquare), options);
  CHECK(w.stack.layers[0].polylines[0].direction == Direction::Inner);
  CHECK(w.stack.layers[0].polylines[1].direction == Direction::Outer);
  CHECK(w.stack.layers[0].polylines[2].direction == Direction::Outer);
  CHECK(w.diagnostics.count("direction_corrected") == 2);
  CHECK(w.diagnostics.count("contour_reversed") == 0);
}

TEST_CASE("A file in which every contour is a hole is oriented by nesting", "[cli]") {
  // Four squares inside each other, one beside them, one of another part inside, in no particular order.
  const auto square = [](int part, double low, double high) {
    std::ostringstream s;
    s << "$$POLYLINE/" << part << ",0,5," << low << "," << low << "," << low << "," << high << "," << high << ","
      << high << "," << high << "," << low << "," << low << "," << low << "\n";
    return s.str();
  };
  const std::string geometry = "$$LAYER/1\n" + square(1, 2, 8) + square(1, 0, 10) + square(1, 4, 6) + square(1, 3, 7) +
                               square(1, 20, 21) + square(2, 2.5, 2.6);
  const Read r = read(text_file(geometry));
  CHECK(r.diagnostics.count("all_contours_are_holes") == 1);
  std::string found;
  for (const Polyline& line : r.stack.layers[0].polylines) {
    found += line.direction == Direction::Outer ? 'o' : 'i';
    CHECK(detail::winding_sign(line.points) == (line.direction == Direction::Outer ? 1 : -1));
  }
  CHECK(found == "ioiooo");
  CliReadOptions options;
  options.orientation = CliOrientation::Dir;
  const Read by_dir = read(text_file(geometry), options);
  for (const Polyline& line : by_dir.stack.layers[0].polylines) CHECK(line.direction == Direction::Inner);
  // One outer boundary in the file, and dir is trusted.
  CHECK(read(text_file(geometry + kSquare)).diagnostics.count("all_contours_are_holes") == 0);
}

TEST_CASE("Nesting of random concentric polygons is their depth", "[cli]") {
  const unsigned seed = 31;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int round = 0; round < 30; ++round) {
    std::vector<std::vector<Point2>> loops;
    for (int ring = 0; ring < 12; ++ring) {
      const int corners = 3 + static_cast<int>(9 * unit(random));
      // Regular polygons with radii far enough apart to lie inside each other, turned at random.
      const double radius = std::pow(2.5, ring);
      const double turn = 6.28 * unit(random);
      std::vector<Point2> p;
      p.reserve(static_cast<std::size_t>(corners));
      for (int i = 0; i < corners; ++i)
        p.push_back(
            {radius * std::cos(turn + 6.283185307 * i / corners), radius * std::sin(turn + 6.283185307 * i / corners)});
      loops.push_back(p);
    }
    std::vector<std::size_t> order(loops.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    std::vector<const std::vector<Point2>*> pointers;
    pointers.reserve(order.size());
    for (const std::size_t i : order) pointers.push_back(&loops[i]);
    const std::function<void()> nobody;
    detail::Poll listen(nobody, 1);
    const auto inside = detail::nesting_parity(pointers, listen);
    for (std::size_t k = 0; k < order.size(); ++k) CHECK(inside[k] == ((loops.size() - 1 - order[k]) % 2 == 1));
  }
}

TEST_CASE("Open lines that end where they began become contours where the file means them so", "[cli]") {
  const std::string ring = "$$POLYLINE/1,2,5,0,0,0,1,1,1,1,0,0,0\n";
  const std::string hole = "$$POLYLINE/1,2,5,0.2,0.2,0.2,0.4,0.4,0.4,0.4,0.2,0.2,0.2\n";
  const std::string line = "$$POLYLINE/1,2,2,0,0,0,1\n";
  const auto directions = [](const Read& r) {
    std::vector<Direction> d;
    for (const Polyline& p : r.stack.layers.at(0).polylines) d.push_back(p.direction);
    return d;
  };
  using D = std::vector<Direction>;
  const auto out = Direction::Outer;
  const auto in = Direction::Inner;
  const auto open = Direction::Open;
  const Read all = read(text_file("$$LAYER/1\n" + ring + hole));
  CHECK(directions(all) == D{out, in});
  CHECK(all.stack.layers[0].polylines[0].points == kSquarePoints);
  CHECK(all.diagnostics.count("open_line_closed") == 2);
  const Read mixed = read(text_file("$$LAYER/1\n" + ring + line));
  CHECK(directions(mixed) == D{open, open});
  CHECK(mixed.stack.layers[0].polylines[0].points.size() == 5);
  CHECK(mixed.diagnostics.count("open_line_with_equal_ends") == 1);
  CHECK(directions(read(text_file("$$LAYER/1\n$$POWER/1\n" + ring + line))) == D{out, open});
  CliReadOptions options;
  options.close_lines = CliCloseLines::Always;
  CHECK(directions(read(text_file("$$LAYER/1\n" + ring + line), options)) == D{out, open});
  options.close_lines = CliCloseLines::Never;
  CHECK(directions(read(text_file("$$LAYER/1\n" + ring), options)) == D{open});
  // There and back encloses nothing.
  options.close_lines = CliCloseLines::Always;
  CHECK(directions(read(text_file("$$LAYER/1\n$$POLYLINE/1,2,5,0,0,1,1,2,2,1,1,0,0\n"), options)) == D{open});
}

TEST_CASE("A count one below the number of points is accepted and said", "[cli]") {
  const Read r = read(text_file("$$LAYER/1\n$$POLYLINE/1,1,4,0,0,1,0,1,1,0,1,0,0\n"));
  CHECK(r.stack.layers[0].polylines[0].points == kSquarePoints);
  CHECK(r.diagnostics.count("point_count_off_by_one") == 1);
  CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/1,1,3,0,0,1,0,1,1,0,1,0,0\n")));
  CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/1,1,6,0,0,1,0,1,1,0,1,0,0\n")));
  CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/1,1,5,0,0,1,0,1,1,0,1,0\n")));
}

TEST_CASE("Repeated points are dropped and counted, and what remains without area or points is dropped", "[cli]") {
  const Read r =
      read(text_file("$$LAYER/1\n$$POLYLINE/1,1,8,0,0,0,0,1,0,1,1,1,1,1,1,0,1,0,0\n$$POLYLINE/1,1,3,5,5,6,6,5,5\n"
                     "$$POLYLINE/1,2,2,3,3,3,3\n$$POLYLINE/1,2,0\n$$POLYLINE/1,1,4,0,0,1,0,1,1,0,1\n"));
  CHECK(r.diagnostics.count("zero_length_segment") == 4);
  CHECK(r.diagnostics.count("degenerate_contour") == 1);
  CHECK(r.diagnostics.count("empty_polyline") == 1);
  CHECK(r.diagnostics.count("unclosed_contour") == 1);
  const std::vector<Polyline>& lines = r.stack.layers[0].polylines;
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].points == kSquarePoints);
  CHECK(lines[1].points == std::vector<Point2>{{3, 3}});
  CHECK(lines[2].points == kSquarePoints);
}

TEST_CASE("Layers of equal z are merged, descending files turned around, others refused", "[cli]") {
  const Read twice = read(text_file("$$LAYER/1\n" + std::string(kSquare) + "$$LAYER/1\n" + kSquare + "$$LAYER/2\n"));
  REQUIRE(twice.stack.layers.size() == 2);
  CHECK(twice.stack.layers[0].polylines.size() == 2);
  CHECK(twice.diagnostics.count("layer_repeated") == 1);
  const Read down = read(text_file("$$LAYER/3\n$$LAYER/2\n" + std::string(kSquare) + "$$LAYER/2$$LAYER/1\n"));
  REQUIRE(down.stack.layers.size() == 3);
  CHECK(down.stack.layers[0].z == 1);
  CHECK(down.stack.layers[1].polylines.size() == 1);
  CHECK(down.diagnostics.count("layers_descend") == 1);
  const std::string bad = text_file("$$LAYER/1\n$$LAYER/2\n$$LAYER/1.5\n");
  const ParseError e = error_of(bad);
  CHECK(e.byte() == bad.find("$$LAYER/1.5"));
  CHECK(e.line() == 8);
}

TEST_CASE("z in mm is recognized by the box or by the thickness", "[cli]") {
  const std::string layers = "$$LAYER/0.1\n" + std::string(kSquare) + "$$LAYER/0.2\n" + kSquare;
  const Read thin = read(text_file(layers, "$$UNITS/0.005\n"));
  CHECK(thin.stack.unit == 0.005);
  CHECK(thin.stack.z_unit == 1);
  CHECK(thin.diagnostics.count("z_in_millimeters") == 1);
  const Read box = read(text_file(layers, "$$UNITS/0.05\n$$DIMENSION/0,0,0,1,1,0.2\n"));
  CHECK(box.stack.z_unit == 1);
  CHECK(read(text_file(layers, "$$UNITS/0.05\n")).stack.z_unit == 0.05);
  CHECK(read(text_file(layers, "$$UNITS/0.05\n$$DIMENSION/0,0,0,1,1,0.01\n")).stack.z_unit == 0.05);
  CliReadOptions options;
  options.z_unit = CliZUnit::Units;
  CHECK(read(text_file(layers, "$$UNITS/0.005\n"), options).stack.z_unit == 0.005);
  options.z_unit = CliZUnit::Millimeters;
  CHECK(read(text_file(layers, "$$UNITS/0.05\n"), options).stack.z_unit == 1);
  CHECK(read(text_file("$$LAYER/100\n$$LAYER/200\n")).diagnostics.count("thickness_implausible") == 1);
}

TEST_CASE("Header keywords that are missing, doubled or late are repaired by name or refused", "[cli]") {
  const std::string geometry = "$$GEOMETRYSTART\n$$LAYER/1\n" + std::string(kSquare) + "$$GEOMETRYEND\n";
  const auto file = [&](const std::string& header, const std::string& end = "$$HEADEREND\n") {
    return "$$HEADERSTART\n" + header + end + geometry;
  };
  CHECK(read(file("$$UNITS/1\n")).diagnostics.count("encoding_missing") == 1);
  CHECK(read(file("$$UNITS/1\n$$ASCII\n", "")).diagnostics.count("header_end_missing") == 1);
  CHECK(read(file("$$UNITS/1\n$$ASCII\n$$UNITS/1.0\n$$ASCII\n")).diagnostics.count("header_keyword_repeated") == 2);
  CHECK(read(file("$$UNITS/1\n$$ASCII\n", "$$HEADEREND\n$$DATE/1\n")).diagnostics.count("header_keyword_late") == 1);
  CHECK(read(file("$$ASCII\n$$UNITS/1\n$$DATE/x\n$$VERSION/1e99\n$$DIMENSION/1,2\n$$LABEL/x\n$$LAYERS/99\n"))
            .diagnostics.count("header_value_unreadable") == 4);
  CHECK(read(file("$$ASCII\n$$UNITS/1\n$$LAYERS/99\n")).diagnostics.count("layer_count_differs") == 1);
  CHECK(read("$$HEADERSTART$$ASCII$$UNITS/1$$HEADEREND$$LAYER/1$$GEOMETRYEND")
            .diagnostics.count("geometry_start_missing") == 1);
  CHECK_FALSE(parses(file("$$ASCII\n")));
  CHECK_FALSE(parses(file("$$ASCII\n$$BINARY\n$$UNITS/1\n")));
  CHECK_FALSE(parses(file("$$ASCII\n$$UNITS/1\n$$UNITS/2\n")));
  CHECK_FALSE(parses(file("$$ASCII\n$$UNITS/1\n$$LAYER/1\n")));
  CHECK_FALSE(parses(file("$$ASCII\n$$UNITS/1\n", "$$HEADEREND\n$$UNITS/1\n")));
  CHECK_FALSE(parses(geometry));
  CHECK_FALSE(parses(""));
  for (const char* unit : {"0", "-1", "nan", "inf", "1e308", "1e-300", "", "x", "1 mm"}) {
    CAPTURE(unit);
    CHECK_FALSE(parses(file(std::string("$$ASCII\n$$UNITS/") + unit + "\n")));
  }
  CliReadOptions options;
  options.unit = 0.5;
  CHECK(read(file("$$ASCII\n"), options).stack.unit == 0.5);
  options.unit = -1;
  CHECK_THROWS_AS(read(file("$$ASCII\n"), options), OptionError);
}

TEST_CASE("An error names the byte and the line", "[cli]") {
  const std::string bad = text_file("$$LAYER/1\n$$POLYLINE/1,1,5,0,0,1,0,oops,1,0,1,0,0\n");
  const ParseError e = error_of(bad);
  CHECK(e.byte() == bad.find("oops"));
  CHECK(e.line() == 7);
  CHECK(e.file() == "sample");
  CHECK(std::string(e.what()).find("line 7") != std::string::npos);
  BinaryFile f;
  f.u16(127).f32(1);
  const std::size_t at = f.bytes.size();
  f.u16(999);
  CHECK(error_of(f.bytes).byte() == at);
  CHECK(error_of(f.bytes).line() == 0);
}

TEST_CASE("Numbers that are no coordinates are refused in every place", "[cli]") {
  for (const char* bad :
       {"nan", "NaN", "inf", "-inf", "infinity", "1e308", "-1e308", "1e999", "--1", "+-1", "0x10", "1.5.5", ""}) {
    CAPTURE(bad);
    const std::string b(bad);
    CHECK_FALSE(parses(text_file("$$LAYER/" + b + "\n")));
    CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/1,1,4,0,0," + b + ",0,1,1,0,0\n")));
    CHECK_FALSE(parses(text_file("$$LAYER/1\n$$HATCHES/1,1,0,0," + b + ",0\n")));
    CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/" + b + ",1,4,0,0,1,0,1,1,0,0\n")));
  }
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float bad : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN(), 3e38f}) {
    CHECK_FALSE(parses(BinaryFile().u16(127).f32(bad).bytes));
    CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(130).u32(1).u32(2).u32(1).f32(0).f32(bad).bytes));
    CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(132).u32(1).u32(1).f32(0).f32(bad).f32(0).f32(0).bytes));
  }
}

TEST_CASE("Counts that the file cannot hold are refused before memory is taken", "[cli]") {
  for (const char* n :
       {"4000000000", "4294967295", "99999999999999999999", "1e18", "-1", "-4000000000", "2.5", "nan"}) {
    CAPTURE(n);
    CHECK_FALSE(parses(text_file("$$LAYER/1\n$$POLYLINE/1,1," + std::string(n) + ",0,0\n")));
    CHECK_FALSE(parses(text_file("$$LAYER/1\n$$HATCHES/1," + std::string(n) + ",0,0,1,1\n")));
  }
  for (const char* head : {"5,1", "1,3", "1,-1", "1,1.5", "3000000000,1"}) {
    CAPTURE(head);
    CHECK(parses(text_file("$$LAYER/1\n$$POLYLINE/" + std::string(head) + ",4,0,0,1,0,1,1,0,0\n")) ==
          (std::string(head) == "5,1"));
  }
  CHECK_FALSE(parses(text_file(kSquare)));  // before any layer
  for (const std::uint32_t n : {0xffffffffu, 0x80000000u, 0x7fffffffu, 2u}) {
    CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(130).u32(1).u32(1).u32(n).f32(0).f32(0).bytes));
    CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(132).u32(1).u32(n).f32(0).f32(0).f32(0).f32(0).bytes));
  }
  CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(129).u16(1).u16(1).u16(65535).u16(0).u16(0).bytes));
  CHECK_FALSE(parses(BinaryFile().u16(127).f32(1).u16(129).u16(1).u16(7).u16(1).u16(0).u16(0).bytes));
  CHECK_FALSE(parses(BinaryFile().u16(129).u16(1).u16(1).u16(1).u16(0).u16(0).bytes));
}

TEST_CASE("Filling bytes at the end of a binary file are no commands", "[cli]") {
  BinaryFile f;
  f.u16(127).f32(1);
  for (std::size_t n = 1; n < 9; ++n) {
    const Read r = read(f.bytes + std::string(n, '\0'));
    CHECK(r.stack.layers.size() == 1);
    CHECK(r.diagnostics.count("trailing_data") == 1);
  }
  CHECK_FALSE(parses(f.bytes + std::string(2, '\0') + "x"));
  CHECK_FALSE(parses(f.bytes + "x"));
}

TEST_CASE("A file cut off anywhere is an error or a valid stack", "[cli][hostile]") {
  const unsigned seed = 17;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const SliceStack stack = random_stack(
      random, [](auto& r) { return std::uniform_int_distribution<int>(0, 400)(r) * 0.25; }, true);
  int cut_text = 0;
  const std::string text = written(stack);
  for (std::size_t n = 0; n < text.size(); ++n) cut_text += parses(text.substr(0, n));
  CHECK(cut_text == 1);  // only the last line end may be missing
  CHECK(parses(text));
  for (const bool align : {false, true})
    for (const bool short_commands : {false, true}) {
      CliWriteOptions options;
      options.binary = true;
      options.align = align;
      options.short_commands = short_commands;
      const std::string binary = written(stack, options);
      int good = 0;
      int bad = 0;
      for (std::size_t n = 0; n < binary.size(); ++n) ++(parses(binary.substr(0, n)) ? good : bad);
      CHECK(good > 0);  // cuts between two commands cannot be told from the end
      CHECK(bad > good);
    }
}

TEST_CASE("A file with changed bytes is an error or a valid stack", "[cli][hostile]") {
  const unsigned seed = 20260101;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  int good = 0;
  int bad = 0;
  for (int round = 0; round < 12; ++round) {
    const SliceStack stack = random_stack(
        random, [](auto& r) { return std::uniform_int_distribution<int>(0, 400)(r) * 0.25; }, true);
    CliWriteOptions options;
    options.binary = round % 2 == 1;
    options.short_commands = round % 4 == 1;
    options.align = round % 3 == 1;
    const std::string original = written(stack, options);
    const std::string alphabet("$/,-+.eE0123456789\n \0\x7f\x80\xff", 24);
    for (int k = 0; k < 600; ++k) {
      std::string bytes = original;
      for (unsigned n = 1 + random() % 4; n > 0; --n) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 4) {
          case 0: bytes[at] = static_cast<char>(random() % 256); break;
          case 1: bytes[at] = alphabet[random() % alphabet.size()]; break;
          case 2: bytes.erase(at, 1 + random() % 9); break;
          default: {
            const std::size_t length = random() % 40;  // one number after the other: arguments have no order
            bytes.insert(at, original.substr(random() % original.size(), length));
          }
        }
        if (bytes.empty()) bytes = "$";
      }
      CliReadOptions read_options;
      read_options.orientation = static_cast<CliOrientation>(k % 4);
      read_options.close_lines = static_cast<CliCloseLines>(k % 3);
      ++(parses(bytes, read_options) ? good : bad);
    }
  }
  CHECK(good > 100);
  CHECK(bad > 100);
}

TEST_CASE("A path that cannot be read is a FileError that names it", "[cli]") {
  const TemporaryDirectory folder;
  for (const std::string& path : {folder.file("absent.cli"), folder.path().string()}) {
    try {
      (void)read_cli(path);
      FAIL("no error");
    } catch (const FileError& e) {
      CHECK(e.path() == path);
      CHECK(e.stage() == Stage::Read);
    }
  }
  std::istringstream broken("x");
  broken.setstate(std::ios::badbit);
  CHECK_THROWS_AS(read_cli(broken), FileError);
}

TEST_CASE("Files, streams and memory give the same stack", "[cli]") {
  const TemporaryDirectory folder;
  const std::string bytes = text_file("$$LAYER/1\n" + std::string(kSquare));
  const std::string path = folder.file("a.cli");
  std::ofstream(path, std::ios::binary) << bytes;
  std::istringstream stream(bytes);
  const SliceStack from_memory = parse_cli(bytes);
  CHECK(read_cli(path) == from_memory);
  CHECK(read_cli(path).source == path);
  CHECK(read_cli(stream) == from_memory);
}

TEST_CASE("Every shared file is read, and the machine dialects are understood", "[cli][data]") {
  const auto files = shared_cli_files();
  if (files.empty()) {
    WARN("skipped: no shared data");
    return;
  }
  int boxes = 0;
  int cylinders = 0;
  for (const auto& path : files) {
    CAPTURE(path.filename().string());
    Diagnostics diagnostics;
    const SliceStack stack = read_cli(path.string(), {}, &diagnostics);
    CHECK(!stack.layers.empty());
    CHECK(stack.z_unit == stack.unit);
    std::size_t closed = 0;
    std::size_t open = 0;
    for (const Layer& layer : stack.layers)
      for (const Polyline& line : layer.polylines) {
        (line.direction == Direction::Open ? open : closed) += 1;
        if (stack.dimension && line.direction != Direction::Open)
          for (const Point2& p : line.points) {
            // The box is in mm and rounded; contours may leave it by the width of a beam.
            CHECK(p.x * stack.unit >= (*stack.dimension)[0] - 0.2);
            CHECK(p.x * stack.unit <= (*stack.dimension)[3] + 0.2);
            CHECK(p.y * stack.unit >= (*stack.dimension)[1] - 0.2);
            CHECK(p.y * stack.unit <= (*stack.dimension)[4] + 0.2);
          }
      }
    CHECK(closed + open > 0);
    if (path.filename() == "Box_support_solid_ascii_with_params.cli") {
      ++boxes;
      CHECK(closed == 910);
      CHECK(open == 0);
      CHECK(diagnostics.count("open_line_closed") == 910);
      CHECK(stack.layers[101].polylines.at(0).process.power == 100);
      CHECK(stack.layers[101].polylines.at(0).process.speed == 200);
    }
    if (path.filename() == "s_Cylinder_ex.cli") {
      ++cylinders;
      CHECK(diagnostics.count("signed_short_coordinates") > 0);
    }
  }
  CHECK(boxes + cylinders > 0);
}
