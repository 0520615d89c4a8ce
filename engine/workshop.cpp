#include "engine/workshop.h"

#include <algorithm>

#include "engine/check.h"

namespace nephele {
namespace {

// A kept buffer serves smaller wishes too, but not at the price of holding on to far more than is needed. (The exact
// blend's pages are some twenty times as large as the volume blend's, and a renderer may go to and fro.)
constexpr VkDeviceSize kMostSpareFactor = 32;
constexpr VkDeviceSize kSmallBytes = 1u << 20;
constexpr std::uint64_t kNotYet = ~std::uint64_t{0};  // put aside while passes are being made

bool fits(const Buffer& buffer, VkDeviceSize bytes) {
  return buffer.bytes() >= bytes && (buffer.bytes() <= kSmallBytes || buffer.bytes() / kMostSpareFactor <= bytes);
}

}  // namespace

template <class T>
Workshop::Kept<T>& Workshop::ask(std::map<std::string, Kept<T>>& kept, const std::string& name) {
  Kept<T>& found = kept[name];
  NEPHELE_CHECK(!found.asked_for, "two resources are called ", name);
  found.asked_for = true;
  return found;
}

Buffer& Workshop::buffer(const std::string& name, VkDeviceSize bytes, Buffer::Memory memory) {
  Kept<Buffer>& kept = ask(buffers_, name);
  const bool device_memory = memory == Buffer::Memory::device;
  if (kept.resource && fits(*kept.resource, bytes) && (kept.resource->mapped() == nullptr) == device_memory)
    return *kept.resource;
  put_aside(std::move(kept.resource), nullptr);
  kept.resource = std::make_unique<Buffer>(device(), name, bytes, memory);
  ++made_count_;
  return *kept.resource;
}

const Buffer& Workshop::uploaded(const std::string& name, std::span<const std::byte> bytes) {
  Kept<Buffer>& kept = ask(buffers_, name);
  if (kept.resource && std::equal(bytes.begin(), bytes.end(), kept.content.begin(), kept.content.end()))
    return *kept.resource;
  put_aside(std::move(kept.resource), nullptr);
  kept.content.assign(bytes.begin(), bytes.end());
  kept.resource = std::make_unique<Buffer>(device(), name, bytes.size());
  kept.resource->write(bytes);
  ++made_count_;
  return *kept.resource;
}

Image& Workshop::image(const std::string& name, const ImageDesc& desc) {
  Kept<Image>& kept = ask(images_, name);
  if (kept.resource && kept.resource->desc() == desc) return *kept.resource;
  put_aside(nullptr, std::move(kept.resource));
  kept.resource = std::make_unique<Image>(device(), name, desc);
  ++made_count_;
  return *kept.resource;
}

void Workshop::put_aside(std::unique_ptr<Buffer> buffer, std::unique_ptr<Image> image) {
  if (buffer || image) unused_.push_back({kNotYet, std::move(buffer), std::move(image)});
}

void Workshop::begin() {
  for (auto& [name, kept] : buffers_) kept.asked_for = false;
  for (auto& [name, kept] : images_) kept.asked_for = false;
}

void Workshop::end(std::uint64_t frames_recorded) {
  for (auto& [name, kept] : buffers_)
    if (!kept.asked_for) put_aside(std::move(kept.resource), nullptr);
  for (auto& [name, kept] : images_)
    if (!kept.asked_for) put_aside(nullptr, std::move(kept.resource));
  std::erase_if(buffers_, [](const auto& entry) { return !entry.second.asked_for; });
  std::erase_if(images_, [](const auto& entry) { return !entry.second.asked_for; });
  for (Unused& unused : unused_)
    if (unused.since_frame == kNotYet) unused.since_frame = frames_recorded;
}

// The last frame that may use them is since_frame - 1; when frame n is recorded, frame n - kFramesInFlight has
// finished.
void Workshop::free_unused(std::uint64_t frames_recorded) {
  std::erase_if(unused_, [&](const Unused& unused) {
    return unused.since_frame != kNotYet && frames_recorded + 1 >= unused.since_frame + kFramesInFlight;
  });
}

}  // namespace nephele
