"""System files that our tool wrote, read and checked by pyssp-standard: the schemas of SSP 1.0 (XSD
1.0 and 1.1) for structure and parameters, and the rules for connections."""

import sys
import warnings
import zipfile

warnings.simplefilter("error")

import xmlschema
from pyssp_standard.ssd import SSD
from pyssp_standard.ssp import SSP
from pyssp_standard.ssv import SSV
from pyssp_standard.standard import ModelicaStandard

for file in sys.argv[1:]:
    with SSP(file, mode="r") as ssp:
        with ssp.system_structure as structure:
            structure.__check_compliance__()
            complaints = structure.check_connections(unconnected_inputs=False,
                                                     connector_not_in_system=True)
            assert not complaints, complaints
            elements = [element.name for element in structure.system.elements]
            assert sorted(elements) == ["controller", "plant"], elements
            assert len(structure.connections()) == 8, structure.connections()
        assert sorted(ssp.resources) == ["controller.fmu", "plant.fmu"], ssp.resources
    with zipfile.ZipFile(file) as archive:
        archive.extractall("unpacked")
        names = archive.namelist()
    schema = xmlschema.XMLSchema10(ModelicaStandard.schemas["ssd"])
    schema.validate("unpacked/SystemStructure.ssd", namespaces=SSD.namespaces)
    sets = [name for name in names if name.endswith(".ssv")]
    assert sets == ["parameters/start.ssv"], names
    with SSV("unpacked/parameters/start.ssv", mode="r") as values:
        values.__check_compliance__()
        names = sorted(parameter["name"] for parameter in values.parameters)
        assert names == ["controller.axis[1].pid.kp", "plant.axis[1].mechanics.damping"], names
    print(f"pyssp-standard, {file}: compliant")
