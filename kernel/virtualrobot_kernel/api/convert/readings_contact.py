"""Readings of contact sensors as messages."""

from __future__ import annotations

from virtualrobot.v1 import sensor_pb2

from virtualrobot_kernel.messages.values import vector_message
from virtualrobot_kernel.sensing.contact_content import Contact, ContactContent


def contact_reading_message(content: ContactContent) -> sensor_pb2.ContactReading:
    """Return a contact sensor's reading as a message."""
    return sensor_pb2.ContactReading(contacts=map(_contact, content.contacts))


def _contact(contact: Contact) -> sensor_pb2.Contact:
    return sensor_pb2.Contact(
        element=contact.element,
        other=contact.other,
        distance_meters=contact.distance,
        point=vector_message(contact.point),
        other_point=vector_message(contact.other_point),
        normal=None if contact.normal is None else vector_message(contact.normal),
    )
