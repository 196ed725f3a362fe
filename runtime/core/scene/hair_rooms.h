// The states that rooms keep of a hair object, in one list.
#pragma once

#include <tuple>
#include <utility>

#include "base/rigid_move.h"
#include "contact/follow_contacts.h"
#include "contact/hair_colliders.h"
#include "contact/hair_grid.h"
#include "passes/buffer_factory.h"
#include "pelage/result.h"
#include "shading/strand_interpolation.h"
#include "shading/strand_motion.h"
#include "simulation/field_forces.h"
#include "simulation/given_positions.h"
#include "simulation/hair_passes.h"
#include "simulation/strand_solver.h"
#include "skinning/hair_frame.h"

namespace pelage::detail {

/// One state of each room, in the order in which they prepare a frame. A state is a plain value,
/// and has of these functions those that it needs:
///
///     void prepare(HairFrame& frame);               // makes and removes its buffers
///     Result<void> record(HairFrame& frame, ...);   // adds its passes: hair_order.cpp calls it
///     void pause(HairFrame& frame);                 // the frame does not simulate the hair
///     void move(const WorldMove& move);             // what the host has in world space
///     std::vector<MovedElements> moved(const HairFrame& frame) const;  // what the GPU has
///     void forget();                                // the GPU may lack what was uploaded
///     void lose(HairBuffers& buffers, const BufferFactory& factory);  // the GPU lost the hair
///     void remove(const BufferFactory& factory);    // or with HairBuffers& before it
using HairRooms = std::tuple<StrandSolver, GivenPositions, HairColliders, FieldForces, HairGrid,
                             FollowContacts, StrandMotion, StrandInterpolation>;

template <class Rooms, class F>
void eachRoom(Rooms& rooms, const F& f) {
  std::apply([&](auto&... room) { (f(room), ...); }, rooms);
}

inline void prepareRooms(HairRooms& rooms, HairFrame& frame) {
  eachRoom(rooms, [&](auto& room) {
    if constexpr (requires { room.prepare(frame); }) room.prepare(frame);
  });
}

inline void pauseRooms(HairRooms& rooms, HairFrame& frame) {
  eachRoom(rooms, [&](auto& room) {
    if constexpr (requires { room.pause(frame); }) room.pause(frame);
  });
}

inline void moveRooms(HairRooms& rooms, const WorldMove& move) {
  eachRoom(rooms, [&](auto& room) {
    if constexpr (requires { room.move(move); }) room.move(move);
  });
}

inline void forgetRooms(HairRooms& rooms) {
  eachRoom(rooms, [](auto& room) {
    if constexpr (requires { room.forget(); }) room.forget();
  });
}

inline void loseRooms(HairRooms& rooms, HairBuffers& buffers, const BufferFactory& factory) {
  eachRoom(rooms, [&](auto& room) {
    if constexpr (requires { room.lose(buffers, factory); }) room.lose(buffers, factory);
  });
}

inline void removeRooms(HairRooms& rooms, HairBuffers& buffers, const BufferFactory& from) {
  eachRoom(rooms, [&](auto& room) {
    if constexpr (requires { room.remove(buffers, from); })
      room.remove(buffers, from);
    else
      room.remove(from);
  });
}

/// Adds the passes that move what rooms have on the GPU, as `add` does for some of its elements.
template <class F>
Result<void> addMoves(const HairRooms& rooms, const HairFrame& frame, const F& add) {
  Result<void> added;
  eachRoom(rooms, [&](const auto& room) {
    if constexpr (requires { room.moved(frame); })
      for (const MovedElements& elements : room.moved(frame))
        if (added) added = add(elements);
  });
  return added;
}

}  // namespace pelage::detail
