#include "tools/fly/fly_app.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "engine/atomic_file.h"
#include "engine/check.h"
#include "engine/image_io.h"
#include "engine/scene_writer.h"
#include "tools/fly/decimal_angles.h"
#include "tools/fly/panel.h"
#include "tools/fly/presenter.h"
#include "tools/fly/truth_run.h"
#include "tools/fly/window.h"

namespace nephele::fly {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

constexpr double kIdleWaitS = 0.1;  // while minimised
constexpr std::uint32_t kMostTruthSidePx = 320;

// "DIRECTORY/picture_0001" with the first number that no file of any of the endings has.
std::string free_name(const std::filesystem::path& directory, const char* name,
                      std::initializer_list<const char*> endings) {
  const std::string stem = (directory / name).string();
  for (int i = 1;; ++i) {
    char number[16];
    std::snprintf(number, sizeof number, "_%04d", i);
    bool taken = false;
    for (const char* ending : endings) taken = taken || std::filesystem::exists(stem + number + ending);
    if (!taken) return stem + number;
  }
}

double resident_mib() {
  std::ifstream status("/proc/self/statm");
  double pages = 0, resident = 0;
  return status >> pages >> resident ? resident * 4096.0 / (1024.0 * 1024.0) : 0.0;
}

SceneValue scene_value(const nlohmann::json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) return value.get<std::vector<double>>();
  return value.get<double>();
}

}  // namespace

class FlyApp {
 public:
  explicit FlyApp(FlyJob job) : job_(std::move(job)), viewer_(job_.start) {}
  ~FlyApp();
  Result<void> run();

 private:
  struct PictureWriter;
  Result<void> open();
  void start_loading();
  Result<void> take_sky();
  FlyInput script_input();
  Result<void> begin_script_step(const ScriptStep& step);
  Result<void> frame(const FlyInput& input, double dt_s);
  Result<void> match_renderer();
  void collect_finished();
  void draw_panel();
  std::vector<Placed> record(VkCommandBuffer commands);
  Result<void> carry_out_requests();
  Result<void> write_picture(const std::string& stem_or_file);
  void save_recording(const Viewer::Requests::Recording& recording);
  void start_truth();
  void end_truth();
  void show_truth();
  Result<void> write_stats() const;
  std::string save_copy();

  FlyJob job_;
  Viewer viewer_;
  Clock::time_point start_ = Clock::now();
  std::unique_ptr<Window> window_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Presenter> presenter_;
  std::unique_ptr<SkyLoader> loader_;
  std::optional<ReadySky> sky_;
  std::uint64_t drawn_version_ = 0;  // of the viewer, that the renderer has been set to
  RenderSettings drawn_, accepted_;  // accepted_: as the user chose them, the last that the renderer took
  PhaseSettings drawn_phase_;
  std::deque<std::pair<std::uint64_t, std::uint64_t>> recorded_;  // presenter's frame, viewer's version
  std::optional<Panel> panel_;
  PanelFacts facts_;
  Panel::Requests asked_;
  std::string save_;     // file for the scene at the end of this frame
  std::string picture_;  // to write once the frame has been drawn at full size
  bool full_size_ = false;
  std::optional<TruthRun> truth_;
  std::optional<Image> truth_image_;
  ImageF truth_rendered_;
  std::uint64_t truth_version_ = 0;
  TruthLook truth_look_ = TruthLook::truth;
  std::vector<std::thread> writers_;
  std::size_t script_step_ = 0;
  std::uint32_t script_frame_ = 0;
  bool script_done_ = false;
  // For the figures.
  double window_ms_ = 0, first_picture_ms_ = 0;
  struct FrameTime {
    double wall_ms, panel_ms, gpu_ms;
    std::size_t step;  // of the script
  };
  std::vector<FrameTime> times_;
  struct Memory {
    double s, resident_mib, device_mib;
  };
  std::vector<Memory> memory_;
};

FlyApp::~FlyApp() {
  for (std::thread& writer : writers_) writer.join();
  truth_.reset();
  loader_.reset();
  if (presenter_) presenter_->finish();
  truth_image_.reset();
  sky_.reset();
  presenter_.reset();
  TruthRun::wait_for_stopped();
}

Result<void> FlyApp::open() {
  Result<std::unique_ptr<Window>> window =
      Window::create(job_.start.settings.width, job_.start.settings.height, "Nephele");
  if (!window) return window.error();
  window_ = std::move(*window);
  job_.device.device_extensions = Presenter::device_extensions();
  job_.device.instance_extensions = Presenter::instance_extensions();
  Result<std::unique_ptr<Device>> device = Device::create(job_.device);
  if (!device) return device.error();
  device_ = std::move(*device);
  if (auto ok = Renderer::check(*device_, viewer_.settings()); !ok) return ok;
  Result<std::unique_ptr<Presenter>> presenter = Presenter::create(*device_, *window_);
  if (!presenter) return presenter.error();
  presenter_ = std::move(*presenter);
  window_ms_ = milliseconds(Clock::now() - start_);
  return {};
}

void FlyApp::start_loading() {
  drawn_ = viewer_.drawn_settings();
  accepted_ = viewer_.settings();
  drawn_version_ = viewer_.version();
  drawn_phase_ = viewer_.scene().phase;
  Scene scene = viewer_.scene_with_camera();
  loader_ = std::make_unique<SkyLoader>(*device_, job_.tables, std::move(scene), drawn_, viewer_.time_s());
}

Result<void> FlyApp::take_sky() {
  std::optional<Result<ReadySky>> ready = loader_->take();
  if (!ready) return {};
  loader_.reset();
  if (!*ready) return ready->error();
  presenter_->finish();
  recorded_.clear();
  sky_ = std::move(**ready);
  if (first_picture_ms_ == 0) first_picture_ms_ = milliseconds(Clock::now() - start_);
  return {};
}

// What the script does in this frame; nothing once it is done.
FlyInput FlyApp::script_input() {
  const std::vector<ScriptStep>& steps = job_.script->steps;
  if (script_step_ < steps.size() && script_frame_ >= steps[script_step_].frames) {
    ++script_step_;
    script_frame_ = 0;
  }
  if (script_step_ >= steps.size()) {
    script_done_ = true;
    return {};
  }
  const ScriptStep& step = steps[script_step_];
  FlyInput scripted = step.input;
  if (script_frame_ > 0) {
    scripted.actions.clear();
    scripted.views.clear();
    scripted.wheel = 0;
  }
  ++script_frame_;
  return scripted;
}

Result<void> FlyApp::begin_script_step(const ScriptStep& step) {
  for (const auto& [key, value] : step.scene)
    if (auto ok = viewer_.edit(key, scene_value(value)); !ok) return ok;
  for (const auto& [key, text] : step.settings)
    for (const Setting& setting : all_settings())
      if (key == setting.key)
        if (auto ok = viewer_.set(setting, text); !ok) return ok;
  if (step.size_px) window_->resize(step.size_px->x, step.size_px->y);
  if (step.window == WindowChange::minimise) window_->minimise();
  if (step.window == WindowChange::restore) window_->restore();
  if (step.window == WindowChange::full_screen) window_->toggle_full_screen();
  save_ = step.save;
  if (!step.picture.empty()) {
    picture_ = step.picture;
    full_size_ = true;
  }
  return {};
}

// The renderer as the viewer wants it. What the device refuses goes back to what was drawn with before.
Result<void> FlyApp::match_renderer() {
  RenderSettings wanted = full_size_ ? viewer_.settings() : viewer_.drawn_settings();
  const bool same_size = wanted.width == drawn_.width && wanted.height == drawn_.height && wanted.scale == drawn_.scale;
  if (viewer_.version() == drawn_version_ && same_size) return {};
  const PhaseSettings& phase = viewer_.scene().phase;
  if (phase.function != drawn_phase_.function || phase.g != drawn_phase_.g) {  // other tables
    end_truth();
    recorded_.clear();
    sky_.reset();
    facts_.stats = nullptr;
    start_loading();
    return {};
  }
  if (auto ok = sky_->renderer->set(viewer_.scene(), wanted); !ok) {
    if (job_.script) return ok;
    viewer_.take_back(accepted_, ok.error().message);
    return {};
  }
  drawn_version_ = viewer_.version();
  accepted_ = viewer_.settings();
  drawn_ = wanted;
  facts_.drawn = drawn_;
  return {};
}

void FlyApp::collect_finished() {
  while (!recorded_.empty() && recorded_.front().first < presenter_->frames_finished()) {
    sky_->renderer->collect();
    const FrameStats& stats = sky_->renderer->stats();
    double gpu_ms = 0;
    for (const PassTime& pass : stats.passes) gpu_ms += pass.gpu_ms;
    if (!stats.passes.empty()) {
      facts_.gpu_ms = gpu_ms;
      if (recorded_.front().second == viewer_.version()) viewer_.frame_took(gpu_ms);
    }
    facts_.stats = &stats;
    recorded_.pop_front();
  }
}

void FlyApp::draw_panel() {
  const auto start = Clock::now();
  ImGui_ImplVulkan_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  if (!sky_) {
    const SkyLoader::Stage stage = loader_ ? loader_->stage() : SkyLoader::Stage{};
    draw_loading(stage.name, stage.fraction);
  } else {
    if (viewer_.panel) asked_ = panel_->draw(viewer_, facts_);
    draw_overlay(viewer_, facts_);
  }
  ImGui::Render();
  facts_.panel_ms = milliseconds(Clock::now() - start);
}

std::vector<Placed> FlyApp::record(VkCommandBuffer commands) {
  if (!sky_) return {};
  sky_->renderer->record(viewer_.camera(), viewer_.time_s(), commands);
  recorded_.emplace_back(presenter_->frames(), viewer_.version());
  std::vector<Placed> pictures{{.image = &sky_->renderer->display()}};
  if (!truth_image_) return pictures;
  // Beside: a quarter of the window, at the lower right. Over half of the picture: the truth's own right half.
  if (panel_->truth_split) {
    pictures.push_back({.image = &*truth_image_, .left = 0.5f, .top = 0, .right = 1, .bottom = 1, .source_left = 0.5f});
  } else {
    pictures.push_back({.image = &*truth_image_, .left = 0.55f, .top = 0.55f, .right = 0.99f, .bottom = 0.99f});
  }
  return pictures;
}

Result<void> FlyApp::frame(const FlyInput& input, double dt_s) {
  const auto frame_start = Clock::now();
  if (sky_) viewer_.step(input, dt_s);
  const glm::uvec2 size = window_->framebuffer_px();
  if (size.x > 0) viewer_.set_image_size(size.x, size.y);
  if (loader_)
    if (auto ok = take_sky(); !ok) return ok;
  if (!presenter_->begin()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return {};
  }
  if (sky_) collect_finished();
  if (sky_)
    if (auto ok = match_renderer(); !ok) return ok;
  if (sky_) show_truth();
  draw_panel();
  presenter_->show([this](VkCommandBuffer commands) { return record(commands); });
  if (sky_) {
    const double wall_ms = milliseconds(Clock::now() - frame_start);
    facts_.frame_ms.push_back(static_cast<float>(wall_ms));
    if (facts_.frame_ms.size() > Panel::kFrames) facts_.frame_ms.pop_front();
    times_.push_back({wall_ms, facts_.panel_ms, facts_.gpu_ms, script_step_});
    if (times_.size() % 50 == 1)
      memory_.push_back({milliseconds(frame_start - start_) * 1e-3, resident_mib(),
                         static_cast<double>(device_->allocated_bytes()) / (1024.0 * 1024.0)});
    return carry_out_requests();
  }
  return {};
}

Result<void> FlyApp::write_picture(const std::string& name) {
  presenter_->finish();
  collect_finished();
  Renderer& renderer = *sky_->renderer;
  const std::uint32_t width = drawn_.width, height = drawn_.height;
  std::vector<std::uint8_t> display = renderer.read_display();
  const std::vector<float> rgba = renderer.read_hdr();
  ImageF hdr{width, height, {"R", "G", "B"}, {}};
  hdr.data.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size(); i += 4) hdr.data.insert(hdr.data.end(), {rgba[i], rgba[i + 1], rgba[i + 2]});
  const bool png = name.ends_with(".png"), exr = name.ends_with(".exr");
  const auto write = [=, display = std::move(display), hdr = std::move(hdr)]() -> Result<void> {
    if (!exr)
      if (auto ok = write_png(png ? name : name + ".png", width, height, display); !ok) return ok;
    return png ? Result<void>() : write_exr(exr ? name : name + ".exr", hdr);
  };
  if (png || exr) return write();  // a script's, which may be read as soon as the program has ended
  viewer_.say("Picture " + name + ".png and .exr");
  writers_.emplace_back([write] {
    if (const auto ok = write(); !ok) std::fprintf(stderr, "nephele: %s\n", ok.error().message.c_str());
  });
  return {};
}

void FlyApp::save_recording(const Viewer::Requests::Recording& recording) {
  const std::string name = free_name(job_.directory, "flight", {".json", "_scene.json"});
  const std::string path = name + ".json", scene = name + "_scene.json";
  for (const Result<void>& done :
       {write_file_atomically(path, recording.path_text), save_scene(recording.scene, scene)})
    if (!done) return viewer_.say(done.error().message);
  std::printf("%s --path '%s' --out '%s_%%04d.png'\n", viewer_.command_line(scene, recording.start_time_s).c_str(),
              path.c_str(), name.c_str());
  viewer_.say("Flight " + path + "; the command that renders it stands on the standard output");
}

std::string FlyApp::save_copy() {
  const std::string name = free_name(job_.directory, "view", {".json"}) + ".json";
  if (const auto ok = save_scene(viewer_.scene_with_camera(), name); !ok) {
    viewer_.say(ok.error().message);
    return "";
  }
  viewer_.say("Scene " + name + "; the command is in the clipboard");
  return viewer_.command_line(name, viewer_.time_s()) + " --out picture.png";
}

void FlyApp::start_truth() {
  presenter_->finish();
  collect_finished();
  std::uint32_t k = 1;
  while (std::max(drawn_.width, drawn_.height) / k > kMostTruthSidePx) ++k;
  ImageF rendered = averaged(sky_->renderer->read_hdr(), drawn_.width, drawn_.height, k);
  TruthRun::View view{.scene = viewer_.scene_with_camera(),
                      .time_s = viewer_.time_s(),
                      .particles = sky_->renderer->read_particles(),
                      .particle_seed = sky_->particle_seed,
                      .width = rendered.width,
                      .height = rendered.height,
                      .rendered = rendered};
  truth_rendered_ = std::move(rendered);
  end_truth();
  truth_.emplace(std::move(view));
  truth_version_ = viewer_.version();
  viewer_.paused = true;  // the clouds stay as they are traced
  facts_.truth_state = "tracing";
  viewer_.say("Path tracing this view (F1, truth: how it is shown)");
}

void FlyApp::end_truth() {
  presenter_->finish();  // which may show it
  collect_finished();
  truth_.reset();
  truth_image_.reset();
  facts_.truth.reset();
  facts_.truth_state.clear();
}

void FlyApp::show_truth() {
  if (!truth_) return;
  if (viewer_.version() != truth_version_ || viewer_.camera() != truth_->view().scene.camera ||
      viewer_.time_s() != truth_->view().time_s)
    return end_truth();  // it is of another view
  std::optional<TruthRun::Progress> news = truth_->news();
  if (news) facts_.truth = std::move(news);
  if (!facts_.truth || (!news && truth_image_ && truth_look_ == panel_->truth_look)) return;
  truth_look_ = panel_->truth_look;
  const ImageF& truth = facts_.truth->truth;
  presenter_->finish();  // the image is written at once
  collect_finished();
  if (!truth_image_ || truth_image_->desc().width != truth.width || truth_image_->desc().height != truth.height)
    truth_image_.emplace(*device_, "truth", ImageDesc{VK_FORMAT_R8G8B8A8_UNORM, truth.width, truth.height});
  const std::vector<std::uint8_t> picture =
      truth_picture(truth, truth_rendered_, truth_look_, viewer_.scene().exposure_ev);
  truth_image_->write(std::as_bytes(std::span(picture)));
}

Result<void> FlyApp::carry_out_requests() {
  if (!save_.empty())
    if (auto ok = viewer_.save(std::exchange(save_, "")); !ok) return ok;
  if (full_size_ && drawn_.width == viewer_.settings().width && drawn_.height == viewer_.settings().height &&
      drawn_.scale == viewer_.settings().scale) {
    full_size_ = false;
    if (auto ok = write_picture(std::exchange(picture_, "")); !ok) return ok;
  }
  const Viewer::Requests requests = viewer_.take_requests();
  const Panel::Requests asked = std::exchange(asked_, {});
  if (requests.picture || asked.picture) {
    picture_ = free_name(job_.directory, "picture", {".png", ".exr"});
    full_size_ = true;
  }
  if (requests.recording) save_recording(*requests.recording);
  if (requests.truth && truth_)
    end_truth();
  else if (requests.truth || asked.truth)
    start_truth();
  if (asked.truth_end) end_truth();
  if (asked.save_copy)
    if (const std::string line = save_copy(); !line.empty()) window_->copy_text(line);
  if (asked.copy_view) window_->copy_text(camera_text(viewer_.camera()));
  if (requests.full_screen) window_->toggle_full_screen();
  return {};
}

// Medians and extremes of what the frames took, by the wall clock.
Result<void> FlyApp::write_stats() const {
  const auto of = [this](auto&& member) {
    std::vector<double> values;
    for (const FrameTime& time : times_) values.push_back(member(time));
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
      return values.empty() ? 0.0 : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    return nlohmann::ordered_json{{"median", at(0.5)}, {"p95", at(0.95)}, {"max", at(1.0)}};
  };
  nlohmann::ordered_json memory = nlohmann::json::array();
  for (const Memory& m : memory_)
    memory.push_back({{"s", m.s}, {"resident_mib", m.resident_mib}, {"device_mib", m.device_mib}});
  std::map<std::size_t, std::vector<double>> by_step;
  for (const FrameTime& time : times_) by_step[time.step].push_back(time.wall_ms);
  nlohmann::ordered_json steps = nlohmann::json::array();
  for (auto& [step, values] : by_step) {
    std::sort(values.begin(), values.end());
    steps.push_back({{"step", step}, {"median_ms", values[values.size() / 2]}, {"max_ms", values.back()}});
  }
  const nlohmann::ordered_json stats{{"device", device_->info().name},
                                     {"window_ms", window_ms_},
                                     {"first_picture_ms", first_picture_ms_},
                                     {"frames", times_.size()},
                                     {"frame_ms", of([](const FrameTime& t) { return t.wall_ms; })},
                                     {"gpu_ms", of([](const FrameTime& t) { return t.gpu_ms; })},
                                     {"panel_ms", of([](const FrameTime& t) { return t.panel_ms; })},
                                     {"steps", steps},
                                     {"memory", memory}};
  return write_file_atomically(job_.stats, stats.dump(2) + "\n");
}

Result<void> FlyApp::run() {
  if (auto ok = open(); !ok) return ok;
  panel_.emplace();
  facts_.drawn = viewer_.drawn_settings();
  start_loading();
  auto last = Clock::now();
  for (bool quit = false; !quit && !window_->closed() && !script_done_;) {
    const bool minimised = window_->framebuffer_px().x == 0;
    FlyInput input = window_->poll(minimised && !job_.script ? kIdleWaitS : 0.0);
    quit = std::find(input.actions.begin(), input.actions.end(), Action::quit) != input.actions.end();
    const std::size_t step = script_step_;
    const bool begins = script_frame_ == 0;
    if (job_.script && sky_) {
      input = script_input();
      if (!script_done_ && (script_step_ != step || begins))
        if (auto ok = begin_script_step(job_.script->steps[script_step_]); !ok) return ok;
      quit = quit || std::find(input.actions.begin(), input.actions.end(), Action::quit) != input.actions.end();
    }
    const auto now = Clock::now();
    const double passed_s = std::chrono::duration<double>(now - last).count();
    last = now;
    const double dt_s = job_.script && job_.script->frame_s ? *job_.script->frame_s : passed_s;
    if (auto ok = frame(input, dt_s); !ok) return ok;
  }
  return job_.stats.empty() ? Result<void>() : write_stats();
}

Result<void> run_fly(FlyJob job) { return FlyApp(std::move(job)).run(); }

}  // namespace nephele::fly
