// A node of the tree in the kernel's form, and the references that nodes and lists hold.
#pragma once

#include <span>

#include "accel/bvh.h"
#include "layout.h"

namespace turner {

// `references`: of single primitives, in the order of Bvh::order.
gpu::uint leafReference(const BvhChild& leaf, std::span<const gpu::uint> references);

// Planes are bytes, rounded outward: multiples of a power of two for each axis, from the lower corner on. All of it is
// exact in double.
gpu::Node packNode(const Bvh::Node& node, std::span<const gpu::uint> references);

}  // namespace turner
