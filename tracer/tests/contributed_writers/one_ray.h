/* A trace of one ray that visits one node. */

static void begin(rbt_writer *writer, const char *path) {
    static const rbt_ray_set set = {"primary", 0, 0};
    static const rbt_node node = {RBT_LEAF, 0, 1, 0};
    static const uint32_t reference = 0;
    rbt_header header;
    rbt_tree tree;
    memset(&header, 0, sizeof header);
    header.generator = header.scene = "one ray";
    header.rays = 1;
    header.ray_sets = &set;
    header.ray_set_count = 1;
    header.accel = "bvh";
    header.traversal = "stack";
    header.node_fetch = "pair";
    header.loop_structure = "while-while";
    memset(&tree, 0, sizeof tree);
    tree.nodes = &node;
    tree.references = &reference;
    tree.node_count = tree.reference_count = tree.triangles = 1;
    if (rbt_begin(writer, path, &header, &tree) != RBT_OK) exit(3);
}

static void fill(rbt_tile *tile) {
    rbt_tile_begin(tile, 0);
    rbt_begin_ray(tile, 0, 0);
    rbt_step(tile, RBT_NODE, 0);
    rbt_end_ray(tile, RBT_MISS);
    if (rbt_tile_end(tile) != RBT_OK) exit(3);
}
