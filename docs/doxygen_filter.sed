# "#V by 3" is a shape; Doxygen takes it for a link unless the # is escaped. Nothing else looks like this in our text.
s/#([A-Z]|bins|slabs)\b/\\#\1/g
# What other builds have is in the reference too: other tetrahedralizers, child processes, concepts.
s/^(#define SLICE2MESH_HAS_(TETGEN|CDT3|CHILD_PROCESSES|CONCEPTS)) 0$/\1 1/
