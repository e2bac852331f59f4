"""Checks the two MaterialX documents of `fit export` with the MaterialX library.

    python in_materialx.py FIT RESULT.json TABLE.h5

Both documents must be valid, and the library must turn them into shaders (GLSL and OSL). The lobe
of the shaders must be retroreflective and have the roughness of the document. One complaint is
expected: MaterialX 1.39.5 has OpenPBR 1.1.1, which has no input specular_retroreflectivity.
"""

import subprocess
import sys

import MaterialX as mx
from MaterialX import PyMaterialXGenGlsl, PyMaterialXGenOsl, PyMaterialXGenShader

fit, result, table = sys.argv[1:]
library = mx.createDocument()
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)


def exported(form):
    text = subprocess.run(
        [fit, "export", result, "--table", table, "--to", form, "--distance", "150"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    document = mx.createDocument()
    mx.readFromXmlString(document, text)
    document.setDataLibrary(library)
    return document


def shaders(document):
    for language in [PyMaterialXGenGlsl.GlslShaderGenerator, PyMaterialXGenOsl.OslShaderGenerator]:
        generator = language.create()
        context = PyMaterialXGenShader.GenContext(generator)
        context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
        shader = generator.generate("sheet", document.getChild("retroreflective_sheet"), context)
        yield language.__name__, shader.getSourceCode(PyMaterialXGenShader.PIXEL_STAGE)


def check(holds, what):
    print(("ok: " if holds else "WRONG: ") + what)
    return holds


passed = []
document = exported("materialx")
valid, said = document.validate()
passed.append(check(valid, f"materialx is valid in MaterialX {mx.getVersionString()} {said}"))
alpha = document.getChild("lobe").getInputValue("roughness")[0]
for name, text in shaders(document):
    set_in = [
        line
        for line in text.splitlines()
        if "lobe_retroreflective = " in line or "lobe_roughness = " in line
    ]
    right = any(
        "retroreflective = true" in line or "retroreflective = 1" in line for line in set_in
    )
    right &= any(f"{alpha:.6f}" in line for line in set_in)
    passed.append(check(right, f"{name}: {'; '.join(line.strip(' ,;') for line in set_in)}"))

document = exported("openpbr")
valid, said = document.validate()
complaints = [line for line in said.splitlines() if line.strip()]
expected = "Input 'specular_retroreflectivity' doesn't match declaration"
passed.append(
    check(
        valid or (len(complaints) == 1 and expected in complaints[0]),
        f"openpbr: {'; '.join(complaints) or 'valid'}",
    )
)
document.getChild("shader").removeInput("specular_retroreflectivity")
valid, said = document.validate()
passed.append(check(valid, f"openpbr without it is valid {said}"))
passed.extend(
    check(len(text) > 0, f"{name} of it: {len(text)} characters")
    for name, text in shaders(document)
)
sys.exit(not all(passed))
