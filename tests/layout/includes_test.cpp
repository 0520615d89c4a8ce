// Who may include whom in the source tree, that no two files share a name, and that headers stand on their own.
#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/support/include_scan.h"
#include "tests/support/support.h"

using namespace nephele::test;

namespace {

namespace fs = std::filesystem;

// A part of the tree. A file may include files of its own part and of parts below, never of another part of its own
// level. What the library is made of includes nothing that is not.
struct Part {
  const char* folder;  // a last "*" stands for one folder name, each of which is a part of its own
  int level;
  bool library;
};

constexpr Part kParts[] = {
    {"shaders/shared", 0, true},
    {"engine", 1, true},
    {"lut", 2, true},
    {"lut/study", 3, false},
    {"tools/path_tracer", 3, false},
    {"passes/kit", 3, true},
    {"passes/*", 4, true},
    {"passes", 5, true},
    {"shaders/kit", 1, true},
    {"shaders/*", 2, true},
    {"tools", 6, false},
    {"tools/shaders", 6, false},
    {"tests", 7, false},
    {"tests/shaders", 7, false},
};

constexpr const char* kSettings = "passes/settings.h";

struct Place {
  std::string folder;  // with the name that "*" stands for
  const Part* part = nullptr;
};

// The part whose folder is the longest that holds the file (its path from the project's root).
Place place_of(const std::string& file) {
  Place best;
  for (const Part& part : kParts) {
    std::string folder = part.folder;
    if (folder.back() == '*') {
      folder.pop_back();
      const std::size_t end = file.find('/', folder.size());
      if (!file.starts_with(folder) || end == std::string::npos) continue;
      folder = file.substr(0, end);
    }
    if (!file.starts_with(folder + "/")) continue;
    // A folder by its own name before the same folder by "*".
    const bool named = folder == part.folder;
    if (folder.size() > best.folder.size() || (folder == best.folder && named)) best = {folder, &part};
  }
  return best;
}

bool is_shader(const std::string& file) {
  const std::string extension = fs::path(file).extension();
  return extension == ".glsl" || extension == ".comp" || extension == ".vert" || extension == ".frag";
}

bool may_include(const std::string& file, const std::string& included) {
  const Place from = place_of(file), to = place_of(included);
  if (from.part == nullptr || to.part == nullptr) return false;
  // The settings stand below the passes' folders: all may ask them, they know none.
  if (included == kSettings) return file.starts_with("passes/") || from.part->level > to.part->level;
  if (file == kSettings) return to.part->level < 3;
  if (from.part->library && !to.part->library) return false;
  // C++ and GLSL share what is in shaders/shared, and nothing else.
  if (to.folder != "shaders/shared" && is_shader(file) != is_shader(included)) return false;
  return from.folder == to.folder || to.part->level < from.part->level;
}

// Every C++ and GLSL file, by its path from the project's root.
std::vector<std::string> source_files() {
  const fs::path root = NEPHELE_SOURCE_DIR;
  std::vector<std::string> files;
  for (const char* folder : {"engine", "lut", "passes", "shaders", "tests", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (extension == ".h" || extension == ".cpp" || is_shader(entry.path().string()))
        files.push_back(fs::relative(entry.path(), root).string());
    }
  }
  return files;
}

// The file that an include names, searched for as the compiler does; empty for a generated one.
std::string included_file(const std::string& file, const std::string& name) {
  const fs::path root = NEPHELE_SOURCE_DIR;
  for (const fs::path& candidate : {fs::path(file).parent_path() / name, fs::path(name), fs::path("shaders") / name})
    if (fs::exists(root / candidate)) return candidate.lexically_normal().string();
  return {};
}

// Names of the standard library, each with the header that is sure to have it.
struct StandardName {
  const char* name;
  const char* header;
};
constexpr StandardName kStandardNames[] = {
    {"int32_t", "cstdint"},
    {"int64_t", "cstdint"},
    {"uint8_t", "cstdint"},
    {"uint16_t", "cstdint"},
    {"uint32_t", "cstdint"},
    {"uint64_t", "cstdint"},
    {"size_t", "cstddef"},
    {"byte", "cstddef"},
    {"ptrdiff_t", "cstddef"},
    {"string", "string"},
    {"to_string", "string"},
    {"string_view", "string_view"},
    {"vector", "vector"},
    {"array", "array"},
    {"map", "map"},
    {"span", "span"},
    {"as_bytes", "span"},
    {"unique_ptr", "memory"},
    {"make_unique", "memory"},
    {"shared_ptr", "memory"},
    {"optional", "optional"},
    {"nullopt", "optional"},
    {"function", "functional"},
    {"move", "utility"},
    {"pair", "utility"},
    {"variant", "variant"},
    {"min", "algorithm"},
    {"max", "algorithm"},
    {"clamp", "algorithm"},
    {"sort", "algorithm"},
    {"sqrt", "cmath"},
    {"exp", "cmath"},
    {"floor", "cmath"},
    {"numeric_limits", "limits"},
    {"memcpy", "cstring"},
    {"filesystem", "filesystem"},
};

std::string without_comments(const std::string& text) {
  std::string code;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    code.append(text, at, std::min(text.find("//", at), end) - at).push_back('\n');
    at = end + 1;
  }
  return code;
}

// Whether `std::name` stands in the code, and no longer name that begins alike.
bool names(const std::string& code, const std::string& name) {
  const std::string whole = "std::" + name;
  for (std::size_t at = code.find(whole); at != std::string::npos; at = code.find(whole, at + 1)) {
    const char next = at + whole.size() < code.size() ? code[at + whole.size()] : ' ';
    if (std::isalnum(static_cast<unsigned char>(next)) == 0 && next != '_') return true;
  }
  return false;
}

// The headers of the standard library that a header names something of and does not include.
std::vector<std::string> missing_standard_headers(const std::string& text) {
  const std::string code = without_comments(text);
  std::vector<std::string> missing;
  for (const StandardName& standard : kStandardNames)
    if (names(code, standard.name) && code.find(std::string("#include <") + standard.header + '>') == std::string::npos)
      missing.emplace_back(standard.header);
  return missing;
}

}  // namespace

TEST_CASE("headers include what they name of the standard library: another library brings less along with the rest") {
  CHECK(missing_standard_headers("std::uint32_t n;  // std::vector\n") == std::vector<std::string>{"cstdint"});
  CHECK(missing_standard_headers("#include <cstdint>\nstd::uint32_t n;\n").empty());
  CHECK(missing_standard_headers("std::move_only_function<int()> f;\n").empty());
  std::size_t seen = 0;
  for (const std::string& file : source_files()) {
    if (!file.ends_with(".h") || file.starts_with("shaders/")) continue;
    ++seen;
    for (const std::string& header : missing_standard_headers(read_file(NEPHELE_SOURCE_DIR "/" + file)))
      FAIL_CHECK(file << " does not include <" << header << ">");
  }
  CHECK(seen > 80);
}

TEST_CASE("the rules of inclusion refuse what they are for") {
  CHECK(may_include("passes/layer/view_sort.h", "passes/kit/radix_sort.h"));
  CHECK(may_include("passes/renderer.cpp", "passes/layer/view_sort.h"));
  CHECK(may_include("passes/layer/cloud_layer.h", "passes/settings.h"));
  CHECK_FALSE(may_include("passes/settings.h", "passes/layer/cloud_layer.h"));
  CHECK_FALSE(may_include("lut/tables.h", "passes/settings.h"));
  CHECK(may_include("tools/main.cpp", "tools/path_tracer/path_tracer.h"));
  CHECK(may_include("shaders/layer/cloud.frag", "shaders/shared/light.h"));
  CHECK(may_include("engine/scene.cpp", "shaders/shared/world.h"));
  CHECK_FALSE(may_include("engine/scene.h", "lut/tables.h"));
  CHECK_FALSE(may_include("lut/tables.cpp", "passes/nephele.h"));
  CHECK_FALSE(may_include("lut/tables.cpp", "lut/study/verification.h"));
  CHECK_FALSE(may_include("passes/renderer.cpp", "lut/study/verification.h"));
  CHECK_FALSE(may_include("passes/kit/radix_sort.h", "passes/layer/view_sort.h"));
  CHECK_FALSE(may_include("passes/sky/composite.h", "passes/light/light_tiles.h"));
  CHECK_FALSE(may_include("passes/layer/view_sort.cpp", "passes/nephele.h"));
  CHECK_FALSE(may_include("tools/path_tracer/path_tracer.cpp", "passes/nephele.h"));
  CHECK_FALSE(may_include("tools/path_tracer/path_tracer.cpp", "passes/kit/radix_sort.h"));
  CHECK_FALSE(may_include("tools/path_tracer/path_tracer.cpp", "tools/command.h"));
  CHECK_FALSE(may_include("passes/renderer.cpp", "tools/command.h"));
  CHECK_FALSE(may_include("tools/main.cpp", "tests/support/support.h"));
  CHECK_FALSE(may_include("shaders/shared/light.h", "engine/camera.h"));
  CHECK_FALSE(may_include("shaders/shared/light.h", "shaders/kit/texels.glsl"));
  CHECK_FALSE(may_include("shaders/kit/camera_rays.glsl", "shaders/layer/blend_state.glsl"));
  CHECK_FALSE(may_include("shaders/light/occlusion.comp", "shaders/sky/composite_tiles.glsl"));
  CHECK_FALSE(may_include("passes/renderer.cpp", "shaders/kit/texels.glsl"));
}

TEST_CASE("every include goes down: tools, passes, lut, engine, shared; the passes' folders know only their kit") {
  std::size_t seen = 0;
  for (const std::string& file : source_files()) {
    for (const std::string& name : quoted_includes(read_file(NEPHELE_SOURCE_DIR "/" + file))) {
      const std::string included = included_file(file, name);
      if (included.empty()) continue;
      ++seen;
      CHECK_MESSAGE(may_include(file, included), file, " includes ", included);
    }
  }
  CHECK(seen > 500);  // the scan does find includes
}

TEST_CASE("no two source files have the same name") {
  std::map<std::string, std::string> files;
  for (const std::string& file : source_files()) {
    const std::string name = fs::path(file).filename();
    if (name == "main.cpp") continue;
    const auto [first, fresh] = files.emplace(name, file);
    CHECK_MESSAGE(fresh, first->second, " and ", file);
  }
}
