//! A scenario with everything that both XML of 2020a and protobuf can say.

/// As XML.
pub const RICH: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Rich-3_2_T-1" timeStepSize="0.2" author="A" affiliation="B" source="C" date="2026-03-04">
  <location><geoNameId>2867714</geoNameId><gpsLatitude>48.25</gpsLatitude><gpsLongitude>11.5</gpsLongitude>
    <geoTransformation><geoReference>EPSG:3857</geoReference><additionalTransformation><xTranslation>1.5</xTranslation><yTranslation>-2.5</yTranslation><zRotation>0.25</zRotation><scaling>2.0</scaling></additionalTransformation></geoTransformation>
    <environment><time>06:30:00</time><timeOfDay>night</timeOfDay><weather>light_rain</weather><underground>ice</underground></environment></location>
  <scenarioTags><urban/><turn_left/><emergency_braking/></scenarioTags>
  <lanelet id="1"><leftBound><point><x>0</x><y>4</y></point><point><x>50</x><y>5</y></point><lineMarking>broad_dashed</lineMarking></leftBound>
    <rightBound><point><x>0</x><y>0</y></point><point><x>20</x><y>0.5</y></point><point><x>50</x><y>1</y></point><lineMarking>curb</lineMarking></rightBound>
    <successor ref="2"/><adjacentLeft ref="2" drivingDir="opposite"/><adjacentRight ref="3" drivingDir="same"/>
    <stopLine><point><x>49</x><y>1</y></point><point><x>49</x><y>5</y></point><lineMarking>solid</lineMarking></stopLine>
    <laneletType>urban</laneletType><laneletType>restricted_area</laneletType><userOneWay>car</userOneWay><userBidirectional>pedestrian</userBidirectional>
    <trafficSignRef ref="20"/><trafficLightRef ref="30"/></lanelet>
  <lanelet id="2"><leftBound><point><x>50</x><y>5</y></point><point><x>90</x><y>5</y></point></leftBound>
    <rightBound><point><x>50</x><y>1</y></point><point><x>90</x><y>1</y></point></rightBound><predecessor ref="1"/><laneletType>intersection</laneletType></lanelet>
  <lanelet id="3"><leftBound><point><x>0</x><y>0</y></point><point><x>50</x><y>1</y></point></leftBound>
    <rightBound><point><x>0</x><y>-4</y></point><point><x>50</x><y>-3</y></point></rightBound><laneletType>crosswalk</laneletType><userOneWay>bicycle</userOneWay></lanelet>
  <trafficSign id="20"><trafficSignElement><trafficSignID>274</trafficSignID><additionalValue>13.89</additionalValue></trafficSignElement><trafficSignElement><trafficSignID>306</trafficSignID></trafficSignElement><position><point><x>3</x><y>-1</y></point></position><virtual>true</virtual></trafficSign>
  <trafficLight id="30"><cycle><cycleElement><duration>7</duration><color>red</color></cycleElement><cycleElement><duration>2</duration><color>redYellow</color></cycleElement><cycleElement><duration>9</duration><color>green</color></cycleElement><cycleElement><duration>1</duration><color>yellow</color></cycleElement><timeOffset>4</timeOffset></cycle><position><point><x>48</x><y>-1</y></point></position><direction>leftStraight</direction><active>false</active></trafficLight>
  <intersection id="40"><incoming id="41"><incomingLanelet ref="1"/><successorsRight ref="3"/><successorsStraight ref="2"/><successorsLeft ref="2"/></incoming><crossing><crossingLanelet ref="3"/></crossing></intersection>
  <staticObstacle id="100"><type>constructionZone</type><shape><polygon><point><x>0</x><y>0</y></point><point><x>2</x><y>0</y></point><point><x>1</x><y>2</y></point></polygon></shape>
    <initialState><position><point><x>9</x><y>8</y></point></position><orientation><exact>0.5</exact></orientation><time><exact>0</exact></time></initialState></staticObstacle>
  <dynamicObstacle id="101"><type>priorityVehicle</type><shape><rectangle><length>5.5</length><width>2.25</width></rectangle></shape>
    <initialState><position><point><x>1</x><y>2</y></point></position><orientation><exact>-7.5</exact></orientation><time><exact>0</exact></time><velocity><exact>3</exact></velocity><acceleration><exact>-1</exact></acceleration><steeringAngle><exact>0.125</exact></steeringAngle></initialState>
    <initialSignalState><time><exact>0</exact></time><horn>true</horn><flashingBlueLights>false</flashingBlueLights></initialSignalState>
    <trajectory><state><position><point><x>2</x><y>2</y></point></position><orientation><intervalStart>-0.5</intervalStart><intervalEnd>0.5</intervalEnd></orientation><time><exact>1</exact></time><velocity><intervalStart>2</intervalStart><intervalEnd>4</intervalEnd></velocity></state>
      <state><position><circle><radius>1.5</radius><center><x>3</x><y>2</y></center></circle></position><time><intervalStart>2</intervalStart><intervalEnd>3</intervalEnd></time><yawRate><exact>0.25</exact></yawRate></state></trajectory>
    <signalSeries><signalState><time><exact>1</exact></time><indicatorLeft>true</indicatorLeft><brakingLights>false</brakingLights></signalState><signalState><time><exact>2</exact></time><indicatorRight>true</indicatorRight><hazardWarningLights>true</hazardWarningLights></signalState></signalSeries></dynamicObstacle>
  <dynamicObstacle id="102"><type>pedestrian</type><shape><circle><radius>0.25</radius></circle></shape>
    <initialState><position><rectangle><length>2</length><width>1</width><orientation>0.5</orientation><center><x>4</x><y>4</y></center></rectangle></position><time><exact>0</exact></time></initialState>
    <occupancySet><occupancy><shape><rectangle><length>4</length><width>2</width><orientation>0.25</orientation><center><x>1</x><y>1</y></center></rectangle><circle><radius>2</radius><center><x>5</x><y>5</y></center></circle></shape><time><intervalStart>1</intervalStart><intervalEnd>2</intervalEnd></time></occupancy></occupancySet></dynamicObstacle>
  <phantomObstacle id="103"><occupancySet><occupancy><shape><polygon><point><x>0</x><y>0</y></point><point><x>2</x><y>0</y></point><point><x>2</x><y>2</y></point></polygon></shape><time><exact>1</exact></time></occupancy></occupancySet></phantomObstacle>
  <environmentObstacle id="104"><type>pillar</type><shape><circle><radius>1</radius><center><x>7</x><y>-9</y></center></circle></shape></environmentObstacle>
  <planningProblem id="200"><initialState><position><point><x>0</x><y>2</y></point></position><orientation><exact>0</exact></orientation><time><exact>0</exact></time><velocity><exact>8</exact></velocity><yawRate><exact>0</exact></yawRate><slipAngle><exact>0</exact></slipAngle></initialState>
    <goalState><time><intervalStart>20</intervalStart><intervalEnd>30</intervalEnd></time><position><lanelet ref="2"/><lanelet ref="3"/></position><velocity><intervalStart>0</intervalStart><intervalEnd>9</intervalEnd></velocity></goalState>
    <goalState><time><intervalStart>5</intervalStart><intervalEnd>6</intervalEnd></time><position><rectangle><length>4</length><width>2</width><orientation>0.25</orientation><center><x>1</x><y>1</y></center></rectangle></position><orientation><intervalStart>-0.25</intervalStart><intervalEnd>0.25</intervalEnd></orientation></goalState></planningProblem>
  <planningProblem id="201"><initialState><position><point><x>0</x><y>2</y></point></position><time><exact>0</exact></time></initialState><goalState><time><exact>9</exact></time></goalState></planningProblem>
</commonRoad>
"#;
