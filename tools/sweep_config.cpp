#include "tools/sweep_config.h"

#include <filesystem>
#include <functional>
#include <set>

#include "engine/check.h"
#include "engine/json_reader.h"
#include "engine/npy.h"
#include "lut/tables.h"
#include "tools/render_stats.h"

namespace nephele::tools {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxScenes = 64, kMaxSeries = 64, kMaxVariants = 1000;
constexpr const char* kScenePrefix = "scene.";

struct NamedScene {
  std::string name, file;
  json document;
  std::shared_ptr<const ImageF> reference;
  std::string reference_hash;
};

struct Series {
  std::string name;
  json settings = json::object(), axes = json::object();
};

std::string hash_of(const std::string& text) { return hex64(fnv1a(std::as_bytes(std::span(text)))); }

bool changes_scene(const std::string& key) { return key.starts_with(kScenePrefix); }

// "scene.clouds.coverage" -> the member of the document, made where it is missing; null when the path meets a value.
json* scene_member(json& document, const std::string& key) {
  json* at = &document;
  for (std::size_t start = std::string(kScenePrefix).size(); start != std::string::npos + 1;) {
    const std::size_t dot = key.find('.', start);
    if (!at->is_object() && !at->is_null()) return nullptr;
    at = &(*at)[key.substr(start, dot == std::string::npos ? dot : dot - start)];
    start = dot == std::string::npos ? std::string::npos + 1 : dot + 1;
  }
  return at;
}

// Nothing where the JSON value is of no kind that a setting may have; a number is not a text that spells one.
std::optional<Value> value_of(const json& value, const Accepted& accepted) {
  if (value.is_string() && (std::holds_alternative<PixelSize>(accepted) || std::holds_alternative<Toggle>(accepted)))
    return read_value(accepted, value.get<std::string>());
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number() && std::holds_alternative<RealNumber>(accepted)) return value.get<double>();
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  return std::nullopt;
}

void read_settings(JsonReader& reader, JsonObject& object, SweepPicture& picture) {
  for (const Setting& setting : all_settings()) {
    const json* found = object.value(setting.key);
    if (!found) continue;
    const std::optional<Value> value = value_of(*found, setting.accepted);
    if (value && accepts(setting.accepted, *value))
      setting.set(picture.render, *value);
    else
      object.complain(*found, object.path_of(setting.key), accepted_words(setting.accepted));
  }
  object.string("table_preset", picture.table_preset);
  if (const auto preset = TableParameters::preset(picture.table_preset); !preset)
    reader.fail(object.path_of("table_preset") + ": " + preset.error().message);
}

// Settings as written in the file, at `path` for complaints; "scene." keys are checked with the scene they change.
void apply_settings(JsonReader& reader, const json& settings, const std::string& path, SweepPicture& picture) {
  json own = settings;
  if (own.is_object())
    for (const auto& [key, value] : settings.items())
      if (changes_scene(key)) own.erase(key);
  JsonObject object(reader, own, path);
  read_settings(reader, object, picture);
  object.finish();
}

// `settings` have been checked where they stand; only the scene that comes of them can still be wrong.
SweepPicture make_picture(JsonReader& reader, const NamedScene& scene, const json& settings) {
  SweepPicture picture;
  apply_settings(reader, settings, "settings", picture);
  json document = scene.document;
  std::string changes;
  for (const auto& [key, value] : settings.items()) {
    if (!changes_scene(key)) continue;
    json* member = scene_member(document, key);
    if (member)
      *member = value;
    else
      reader.fail(key + " is not a member of the scene file");
    changes += concat(changes.empty() ? " with " : ", ", key, " = ", value.dump());
  }
  Result<Scene> parsed =
      parse_scene(document.dump(), scene.file + changes, std::filesystem::path(scene.file).parent_path().string());
  if (parsed)
    picture.scene = std::move(*parsed);
  else
    reader.fail(parsed.error().message);
  picture.description = describe(picture, document);
  if (const auto& clouds = picture.scene.clouds; clouds && clouds->weather_map)  // the document only names its file
    picture.description["weather_map"] = hex64(fnv1a(std::as_bytes(std::span(clouds->weather_map->texels))));
  if (const auto& terrain = picture.scene.terrain)  // likewise
    picture.description["terrain"] = hex64(fnv1a(std::as_bytes(std::span(terrain->texels))));
  picture.key = hash_of(picture.description.dump());
  return picture;
}

// The part of the settings that decides which scene is seen at which size: a reference shares it.
json view_of(const json& settings) {
  json view = json::object();
  for (const auto& [key, value] : settings.items())
    if (changes_scene(key) || key == "resolution") view[key] = value;
  return view;
}

std::string shown(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

std::string short_key(const std::string& key) { return changes_scene(key) ? key.substr(key.rfind('.') + 1) : key; }

// Calls visit(place) for every place on the axes, the last one running fastest.
void each_place(const json& axes, json::const_iterator axis, json& place,
                const std::function<void(const json&)>& visit) {
  if (axis == axes.end()) return visit(place);
  const json::const_iterator next = std::next(axis);
  for (const json& value : axis.value()) {
    place[axis.key()] = value;
    each_place(axes, next, place, visit);
  }
}

class SweepReader {
 public:
  explicit SweepReader(const std::string& path)
      : directory_(std::filesystem::path(path).parent_path()), reader_(path) {}

  Result<Sweep> read(const json& document, const json& typed) {
    JsonObject root = reader_.root(document);
    for (const char* key : {"scenes", "series"}) root.require(key);
    root.objects("scenes", kMaxScenes, [&](JsonObject& child) { read_scene(child); });
    common_ = read_raw_settings(root, "settings");
    common_.update(typed);
    if (root.has("reference")) reference_ = read_raw_settings(root, "reference");
    root.objects("series", kMaxSeries, [&](JsonObject& child) { read_series(child); });
    root.integer("warmup_frames", sweep_.warmup_frames, 1, 100);
    root.integer("frames", sweep_.frames, 1, 1000);
    root.integer("repetitions", sweep_.repetitions, 1, 1000);
    root.finish();
    if (!reader_.error()) make_variants();
    if (reader_.error()) return *reader_.error();
    return std::move(sweep_);
  }

 private:
  std::string beside(const std::string& file) const { return (directory_ / file).lexically_normal().string(); }

  void read_scene(JsonObject& object) {
    NamedScene scene;
    std::string reference;
    object.require("name");
    object.require("file");
    object.string("name", scene.name);
    object.string("file", scene.file);
    object.string("reference", reference);
    if (reader_.error()) return;
    for (const NamedScene& other : scenes_)
      if (other.name == scene.name)
        reader_.fail(object.path_of("name") + " is \"" + scene.name + "\", as another scene's");
    scene.file = beside(scene.file);
    const Result<std::string> text = read_text_file(scene.file);
    const Result<json> document = text ? parse_json(*text, scene.file) : Result<json>(text.error());
    if (document)
      scene.document = *document;
    else
      reader_.fail(document.error().message);
    if (!reference.empty()) read_reference(beside(reference), scene);
    scenes_.push_back(std::move(scene));
  }

  void read_reference(const std::string& file, NamedScene& scene) {
    Result<ImageF> image = read_exr(file);
    if (!image) return reader_.fail(image.error().message);
    scene.reference_hash = hex64(fnv1a(std::as_bytes(std::span(image->data))));
    scene.reference = std::make_shared<const ImageF>(std::move(*image));
  }

  // Settings stay as they are written, since they are merged as such; what is wrong with them is said here.
  json read_raw_settings(JsonObject& object, const char* key) {
    const json* found = object.value(key);
    if (!found) return json::object();
    SweepPicture checked;
    apply_settings(reader_, *found, object.path_of(key), checked);
    return *found;
  }

  void read_series(JsonObject& object) {
    Series series;
    object.require("name");
    object.string("name", series.name);
    series.settings = read_raw_settings(object, "settings");
    if (const json* axes = object.value("axes")) series.axes = *axes;
    const std::string path = object.path_of("axes");
    if (!series.axes.is_object())
      return reader_.fail(path + " is " + series.axes.dump() + "; accepted: an object of arrays");
    for (const auto& [key, values] : series.axes.items()) {
      if (!values.is_array() || values.empty())
        return reader_.fail(path + '.' + key + " is " + values.dump() + "; accepted: an array of at least one value");
      for (const json& value : values) {
        json setting = json::object();
        setting[key] = value;
        SweepPicture checked;
        apply_settings(reader_, setting, path, checked);
      }
    }
    for (const Series& other : series_)
      if (other.name == series.name)
        reader_.fail(object.path_of("name") + " is \"" + series.name + "\", as another series'");
    series_.push_back(std::move(series));
  }

  void make_variants() {
    if (scenes_.empty()) reader_.fail("scenes is []; accepted: at least one scene");
    if (series_.empty()) reader_.fail("series is []; accepted: at least one series");
    json everything = {sweep_.warmup_frames, sweep_.frames, sweep_.repetitions};
    std::set<std::string> keys;
    for (const NamedScene& scene : scenes_) {
      for (const Series& series : series_) {
        json place = json::object();
        each_place(series.axes, series.axes.begin(), place, [&](const json& at) {
          if (reader_.error()) return;
          add_variant(scene, series, at);
          if (reader_.error()) return;
          const SweepVariant& added = sweep_.variants.back();
          if (!keys.insert(added.picture.key).second)
            reader_.fail("the variant \"" + added.name() + "\" is the same as one before it");
          everything.push_back({added.name(), added.picture.key, scene.reference_hash,
                                added.reference_picture ? added.reference_picture->key : ""});
        });
      }
    }
    sweep_.hash = hash_of(everything.dump());
  }

  void add_variant(const NamedScene& scene, const Series& series, const json& place) {
    if (sweep_.variants.size() == kMaxVariants)
      return reader_.fail(concat("there are more than ", kMaxVariants, " variants"));
    json settings = common_;
    settings.update(series.settings);
    settings.update(place);
    SweepVariant variant{
        .scene = scene.name, .series = series.name, .axes = place, .picture = make_picture(reader_, scene, settings)};
    for (const auto& [key, value] : place.items())
      variant.place += concat(variant.place.empty() ? "" : " ", short_key(key), '=', shown(value));
    if (scene.reference) {
      const RenderSettings& render = variant.picture.render;
      if (scene.reference->width != render.width || scene.reference->height != render.height)
        reader_.fail(concat("the reference of scene ", scene.name, " has ", scene.reference->width, 'x',
                            scene.reference->height, " pixels; the variant \"", variant.name(), "\" has ", render.width,
                            'x', render.height));
      variant.reference_image = scene.reference;
    } else if (reference_) {
      json reference_settings = view_of(settings);
      reference_settings.update(*reference_);
      variant.reference_picture = make_picture(reader_, scene, reference_settings);
    }
    sweep_.variants.push_back(std::move(variant));
  }

  std::filesystem::path directory_;
  JsonReader reader_;
  std::vector<NamedScene> scenes_;
  std::vector<Series> series_;
  json common_ = json::object();
  std::optional<json> reference_;
  Sweep sweep_;
};

}  // namespace

json describe(const SweepPicture& picture, const json& scene_document) {
  json description{{"table_preset", picture.table_preset}, {"scene", scene_document}};
  description["scene"].erase("views");  // a sweep looks from the camera alone
  for (const Setting& setting : all_settings()) description[setting.key] = json_of(setting.get(picture.render));
  return description;
}

Result<Sweep> load_sweep(const std::string& path, const json& typed) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  const Result<json> document = parse_json(*text, path);
  if (!document) return document.error();
  return SweepReader(path).read(*document, typed);
}

}  // namespace nephele::tools
