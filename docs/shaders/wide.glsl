// Wide BVH with a full stack: the children that are hit are sorted, the nearest is next, the others are pushed. WIDTH and the node's record
// come from the file that includes this one: wide-full-4.glsl, wide-full-8.glsl, wide-compressed-8.glsl, wide-adreno-8.glsl.
//
// A reference to a leaf has bit 31 set, the number of its triangles in the next 7 bits, and the first of them in the rest. Children that are missed, or
// are not there, are at an infinite distance.

// A leaf that is none: the end of the search.
const uint END = NONE;
const float MISSED = uintBitsToFloat(0x7F800000u);

uvec2 stack[128];
uint top;

bool isLeaf(uint reference) {
    return int(reference) < 0;
}

uint pop(float end) {
    while (top > 0u) {
        top--;
        uvec2 entry = stack[top];
        if (uintBitsToFloat(entry.y) <= end) {
            return entry.x;
        }
    }
    return END;
}

// Where the ray enters the box between the planes, or MISSED.
float enter(Ray ray, vec3 low, vec3 high, float end) {
    vec2 span = slab(ray, low, high, end);
    return span.x <= span.y ? span.x : MISSED;
}

// Lower distance first.
#define SORT(a, b) { bool swap = distances[b] < distances[a]; float d = swap ? distances[b] : distances[a]; \
    distances[b] = swap ? distances[a] : distances[b]; distances[a] = d; \
    uint c = swap ? children[b] : children[a]; children[b] = swap ? children[a] : children[b]; children[a] = c; }

#if WIDTH == 4
#define SORT_ALL SORT(0, 1) SORT(2, 3) SORT(0, 2) SORT(1, 3) SORT(1, 2)
#else
// Batcher 1968: 19 comparisons.
#define SORT_ALL SORT(0, 1) SORT(2, 3) SORT(4, 5) SORT(6, 7) SORT(0, 2) SORT(1, 3) SORT(4, 6) SORT(5, 7) SORT(1, 2) SORT(5, 6) \
    SORT(0, 4) SORT(1, 5) SORT(2, 6) SORT(3, 7) SORT(2, 4) SORT(3, 5) SORT(1, 2) SORT(3, 4) SORT(5, 6)
#endif

#define PUSH(i) if (distances[i] < MISSED) { stack[top] = uvec2(children[i], floatBitsToUint(distances[i])); top++; }

bool trace(Ray ray, bool any, inout Hit hit) {
    uint node = 0u;
    top = 0u;
    for (;;) {
        while (!isLeaf(node)) {
            float distances[WIDTH];
            uint children[WIDTH];
            READ_NODE
            SORT_ALL
#if WIDTH == 8
            PUSH(7) PUSH(6) PUSH(5) PUSH(4)
#endif
            PUSH(3) PUSH(2) PUSH(1)
            node = distances[0] < MISSED ? children[0] : pop(hit.t);
        }
        if (node == END) {
            return hit.triangle != NONE;
        }
        uint triangle = node & 0xFFFFFFu;
        uint last = triangle + (node >> 24 & 0x7Fu);
        for (; triangle < last; triangle++) {
            intersect(triangle, ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        node = pop(hit.t);
    }
}
