// The state of a shot's simulation in a file, to go on from with the same bits.
//
// The host's part of the state follows from the inputs alone, because a scene reads nothing back.
// So a checkpoint has only the bytes of all buffers; restoring notes the steps before it once more
// (ShotScene::note()), which makes the same buffers, and gives these their bytes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "pelage/headless.h"
#include "pelage/result.h"
#include "shot_scene.h"

namespace pelage::bake {

/// Identifies the state that a checkpoint holds.
struct CheckpointKey {
  uint64_t fingerprint = 0;  ///< of the shot
  uint64_t steps = 0;        ///< that have run
  std::string device;        ///< deviceName()
};

/// GPU, driver and API: others may round otherwise.
std::string deviceName(const DeviceInfo& info);

/// Writes the state behind a step. \return bytes of the file. Errors: those of the device and of
/// the disk.
Result<uint64_t> saveCheckpoint(const std::filesystem::path& path, std::string_view tag,
                                const CheckpointKey& key, ShotScene& scene, HeadlessDevice& device);

/// Brings a scene that has run no step, and that no device has, to a checkpoint. Errors: a file
/// that is of something else, or damaged; the scene is of no use then.
Result<void> loadCheckpoint(const std::filesystem::path& path, const CheckpointKey& key,
                            ShotScene& scene);

}  // namespace pelage::bake
