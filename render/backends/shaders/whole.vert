// One triangle over the whole image, at a depth that says which part of a mesh is drawn.

uniform float mark;

void main()
{
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, mark, 1.0);
}
