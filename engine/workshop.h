// What passes are made with: the pipelines that all share (kernels.h) and the buffers and images of one renderer, by
// name.
//
// When a renderer's scene or settings change its passes are made anew, and ask for the same things again: what they
// have asked for before and still fits is handed out again, so another sun or another coverage allocates nothing.
// Frames may still be under way with what is no longer asked for: it is put aside, and freed once they have finished.
//
//   workshop.begin();             // nothing is asked for yet
//   ... make passes: buffer(), image(), uploaded() ...
//   workshop.end(executor.frames_recorded());
//   ... before each further frame: workshop.free_unused(executor.frames_recorded());
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/frame.h"
#include "engine/kernels.h"
#include "engine/resources.h"

namespace nephele {

class Workshop {
 public:
  explicit Workshop(Kernels& kernels) : kernels_(kernels) {}

  Device& device() const { return kernels_.device(); }
  const ComputeKernel& compute(const ShaderCode& code, std::span<const SpecConstant> constants = {}) {
    return kernels_.compute(code, constants);
  }
  const RasterPipeline& raster(const RasterDesc& desc) { return kernels_.raster(desc); }

  // At least so many bytes. A name may be asked for once between begin() and end(). The contents are zeros, or what
  // earlier frames left.
  Buffer& buffer(const std::string& name, VkDeviceSize bytes, Buffer::Memory memory = Buffer::Memory::device);
  // A device buffer that holds these bytes (at least one of them) and that no frame writes. Other bytes get another
  // buffer, so that frames under way keep theirs.
  const Buffer& uploaded(const std::string& name, std::span<const std::byte> bytes);
  // Of exactly this description. The contents are undefined, or what earlier frames left.
  Image& image(const std::string& name, const ImageDesc& desc);

  void begin();
  void end(std::uint64_t frames_recorded);
  void free_unused(std::uint64_t frames_recorded);

  // Buffers and images made so far, those that have been freed included.
  std::size_t made_count() const { return made_count_; }

 private:
  template <class T>
  struct Kept {
    std::unique_ptr<T> resource;
    std::vector<std::byte> content;  // of an uploaded buffer
    bool asked_for = false;
  };
  struct Unused {
    std::uint64_t since_frame;
    std::unique_ptr<Buffer> buffer;
    std::unique_ptr<Image> image;
  };

  template <class T>
  Kept<T>& ask(std::map<std::string, Kept<T>>& kept, const std::string& name);
  void put_aside(std::unique_ptr<Buffer> buffer, std::unique_ptr<Image> image);

  Kernels& kernels_;
  std::map<std::string, Kept<Buffer>> buffers_;
  std::map<std::string, Kept<Image>> images_;
  std::vector<Unused> unused_;
  std::size_t made_count_ = 0;
};

}  // namespace nephele
