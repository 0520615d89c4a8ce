// What earlier frames left standing. For each resource it keeps the bytes of the inputs that its content was made from,
// so that a step whose inputs stayed the same need not run again. One memory serves all steps of an executor; a frame's
// claims reach it once the frame has been recorded, so a frame that was built and dropped changes nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <vector>

namespace nephele {

// Inputs as bytes, for comparison. Only types whose equal values have equal bytes: no padding, no -0 beside 0.
using InputBytes = std::vector<std::byte>;

template <class... Ts>
InputBytes as_inputs(const Ts&... values) {
  InputBytes bytes((sizeof(Ts) + ... + 0));
  std::size_t at = 0;
  const auto append = [&](const auto& value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
    at += sizeof value;
  };
  (append(values), ...);
  return bytes;
}

class StepMemory {
 public:
  struct Claim {
    std::uint64_t resource;  // Buffer::id or Image::id
    InputBytes inputs;       // that the resource's content is made from
  };

  bool holds(std::uint64_t resource, const InputBytes& inputs) const {
    const auto found = inputs_.find(resource);
    return found != inputs_.end() && found->second == inputs;
  }
  void commit(const std::vector<Claim>& claims) {
    for (const Claim& claim : claims) inputs_[claim.resource] = claim.inputs;
  }
  void forget() { inputs_.clear(); }

 private:
  std::map<std::uint64_t, InputBytes> inputs_;
};

}  // namespace nephele
