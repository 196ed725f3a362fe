// Includes all of the core: assets, scenes, pass lists, settings, and the generated kernels and
// layouts.
//
// Not included, because they need other headers or libraries: the C interface (pelage/pelage_c.h),
// the runtimes (pelage/vulkan.h, pelage/gl.h), devices without a window (pelage/headless.h), inputs
// for ray tracing (pelage/ray_tracing.h), the import of meshes (pelage/mesh_import.h), tools that
// prepare assets (pelage/authoring/) and the generated character and grooms (pelage/demo/).
//
// Threads: every class says what it takes. Data (settings, assets, definitions, lists) is as a
// standard container: several threads may read one while none writes it. Functions that belong to
// no class may be called on any thread.
#pragma once

#include "pelage/assert.h"
#include "pelage/asset_cache.h"
#include "pelage/binding.h"
#include "pelage/bone_weights.h"
#include "pelage/cache_player.h"
#include "pelage/camera.h"
#include "pelage/collider.h"
#include "pelage/collision_mesh.h"
#include "pelage/engine_lights.h"
#include "pelage/export.h"
#include "pelage/force_field.h"
#include "pelage/frame.h"
#include "pelage/gpu_structs.h"
#include "pelage/hair_asset.h"
#include "pelage/hair_buffers.h"
#include "pelage/hair_cache.h"
#include "pelage/hair_depth.h"
#include "pelage/hair_object.h"
#include "pelage/host_allocator.h"
#include "pelage/ids.h"
#include "pelage/kernel.h"
#include "pelage/kernel_code.h"
#include "pelage/kernel_code_table.h"
#include "pelage/kernels.h"
#include "pelage/layout.h"
#include "pelage/layouts.h"
#include "pelage/light.h"
#include "pelage/list_check.h"
#include "pelage/metal_kernel.h"
#include "pelage/pass_list.h"
#include "pelage/random.h"
#include "pelage/result.h"
#include "pelage/sag_compensation.h"
#include "pelage/scene.h"
#include "pelage/scene_features.h"
#include "pelage/sdf_collider.h"
#include "pelage/simulation_settings.h"
#include "pelage/skeleton.h"
#include "pelage/skeleton_pose.h"
#include "pelage/skin_table.h"
#include "pelage/strand_texture.h"
#include "pelage/stream.h"
#include "pelage/tier.h"
#include "pelage/transparency.h"
#include "pelage/types.h"
#include "pelage/version.h"
#include "pelage/view.h"
