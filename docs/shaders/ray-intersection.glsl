// The loop around an instruction that tests one node or triangle of a wide BVH, after Mesa's tu_nir_lower_ray_query.cc, for one level. A message of two vec4
// and an answer of two stand in for the instruction: what it found and, of a node, its children from far to near, 3 bits each, and in the lowest 5 bits the place of
// the nearest; of a triangle distance and barycentrics.
layout(std430, binding = 0) buffer Unit {
    uvec4 messages[];
};

// Links to parents.
layout(std430, binding = 4) readonly buffer Parents {
    uint parents[];
};

#define ENTRIES 8u
#define LEAF 0x100u
#define PLACES 0x24924900u

bool trace(Ray ray, bool any, inout Hit hit) {
    // First child, and children still to be visited.
    uvec2 stack[8];
    uint top = 0u;
    uint lost = 0u;
    uint node = 0u;
    uint previous = NONE;
    for (;;) {
        if (node == NONE) {
            if (top == 0u) {
                return hit.triangle != NONE;
            }
            if (top <= lost) {
                node = parents[previous];
                if (node == NONE) {
                    return hit.triangle != NONE;
                }
            } else {
                uvec2 entry = stack[(top - 1u) & (ENTRIES - 1u)];
                uint place = (entry.y & 31u) - 3u;
                node = entry.x + (entry.y >> place & 7u);
                if (place == 8u) {
                    top--;
                } else {
                    stack[(top - 1u) & (ENTRIES - 1u)].y = (entry.y & 0xFFFFFFE0u) | place;
                }
                previous = NONE;
            }
        } else {
            previous = NONE;
        }
        uint climbedFrom = previous;
        previous = node;
        messages[4u * node] = uvec4(floatBitsToUint(ray.origin), floatBitsToUint(hit.t));
        messages[4u * node + 1u] = uvec4(floatBitsToUint(ray.direction), 0u);
        memoryBarrierBuffer();
        uvec4 found = messages[4u * node + 2u];
        uvec4 where = messages[4u * node + 3u];
        uint count = found.x >> 4 & 15u;
        if ((found.x & LEAF) != 0u) {
            node = NONE;
            if (count != 0u) {
                hit = Hit(uintBitsToFloat(where.x), uintBitsToFloat(where.y), uintBitsToFloat(where.z), found.y);
                if (any) {
                    return true;
                }
            }
        } else if (count != 0u) {
            uint children = found.w;
            if (climbedFrom == NONE) {
                node = found.y + (children >> (children & 31u) & 7u);
                if (count > 1u) {
                    stack[top & (ENTRIES - 1u)] = uvec2(found.y, children);
                    top++;
                    lost = uint(max(int(lost), int(top) - int(ENTRIES)));
                }
            } else {
                uint same = (climbedFrom - found.y) * (PLACES >> 2) ^ children;
                uint place = uint(findLSB((same - (PLACES >> 2)) & ~same & PLACES));
                node = place == 10u ? NONE : found.y + (children >> (place - 5u) & 7u);
            }
        } else {
            node = NONE;
        }
    }
}
